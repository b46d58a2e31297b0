#include "tools/program/interrupt.h"

#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <ctime>
#include <mutex>
#include <string_view>
#include <thread>

#include "tools/program/exit_codes.h"

namespace unlatch::tools {
namespace {

using namespace std::chrono_literals;

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // a signal handler may set it
sem_t terminated;                                       // posted by SIGTERM

// The rule: after SIGTERM the main thread has kOrderly to end the session and to report. From then on the process ends
// at the end of the first kLook in which that thread has not worked: it has computed for less than kWorking, and does
// not wait for a processor. So a process in which anything hangs, a write or another thread, ends within a second;
// computing a report may take longer, and is not cut short.
constexpr auto kOrderly = 600ms;
constexpr auto kLook = 100ms;
constexpr auto kWorking = 5ms;
static_assert(kOrderly + kLook < 1s, "the documents promise the end of a process that hangs within a second");

std::chrono::nanoseconds get_time(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

// The state in /proc/self/stat is the main thread's: R, it runs or waits for a processor.
bool is_main_thread_runnable() {
  std::array<char, 512> text{};
  const int file = open("/proc/self/stat", O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const ssize_t length = read(file, text.data(), text.size());
  close(file);
  const std::string_view stat(text.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  return stat.substr(std::min(stat.rfind(')'), stat.size())).starts_with(") R");
}

// Waits for SIGTERM; then ends the process by the rule above.
void watch_main_thread(clockid_t main_thread) {
  while (sem_wait(&terminated) != 0) {
  }
  std::this_thread::sleep_for(kOrderly);
  while (true) {
    const auto before = get_time(main_thread);
    std::this_thread::sleep_for(kLook);
    if (get_time(main_thread) - before >= kWorking || is_main_thread_runnable()) continue;
    static constexpr char kText[] = "ended by SIGTERM; something hung, so that the end was not an orderly one\n";
    fcntl(STDERR_FILENO, F_SETFL, fcntl(STDERR_FILENO, F_GETFL) | O_NONBLOCK);
    (void)!write(STDERR_FILENO, kText, sizeof kText - 1);
    std::_Exit(kExitFailed);
  }
}

void start_watching() {
  clockid_t main_thread{};
  sem_init(&terminated, 0, 0);
  if (pthread_getcpuclockid(pthread_self(), &main_thread) != 0) return;
  // The signals are for the other threads: this one only sleeps.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  std::thread(watch_main_thread, main_thread).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void set_handler(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

const std::atomic<bool>& catch_interrupts() {
  static std::once_flag once;
  std::call_once(once, start_watching);
  set_handler([](int signal) {
    interrupted.store(true);
    if (signal == SIGTERM) sem_post(&terminated);
  });
  return interrupted;
}

const std::atomic<bool>& catch_interrupts_patiently() {
  set_handler([](int) { interrupted.store(true); });
  return interrupted;
}

// A pipe is opened once more: the new description is ours alone. Of a socket, which cannot be opened again, the longest
// wait is set.
void never_wait_for_stderr() {
  struct stat what {};
  if (fstat(STDERR_FILENO, &what) != 0) return;
  if (S_ISSOCK(what.st_mode)) {
    const timeval least{.tv_sec = 0, .tv_usec = 1000};
    (void)setsockopt(STDERR_FILENO, SOL_SOCKET, SO_SNDTIMEO, &least, sizeof least);
  } else if (S_ISFIFO(what.st_mode)) {
    const int file = open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return;
    (void)dup2(file, STDERR_FILENO);
    close(file);
  }
}

}  // namespace unlatch::tools
