// The end after SIGTERM, in processes of the test itself. No time is asserted: one end comes before another.
#include "tools/program/interrupt.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <ctime>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "tools/program/exit_codes.h"

namespace unlatch::test {
namespace {

using namespace std::chrono_literals;

constexpr double kReport_s = 3;       // processor time, more than a process that hangs is given by the clock
constexpr int kPatience_ms = 60'000;  // a process that hangs would never end

double get_processor_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

// A process that runs `life` after it has begun to catch signals, and ends with its result.
class Process {
 public:
  explicit Process(const std::function<int(const std::atomic<bool>&)>& life) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("pipe");
    id_ = fork();
    if (id_ == 0) {
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      close(ends[1]);
      const std::atomic<bool>& interrupted = tools::catch_interrupts();
      (void)!write(STDERR_FILENO, "!", 1);
      _exit(life(interrupted));
    }
    close(ends[1]);
    said_ = ends[0];
    (void)!read(said_, &ready_, 1);
  }
  ~Process() {
    kill(id_, SIGKILL);
    (void)end();
    close(said_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void terminate() const { kill(id_, SIGTERM); }
  [[nodiscard]] bool has_ended() {
    if (!ended_ && waitpid(id_, &status_, WNOHANG) == id_) ended_ = true;
    return ended_;
  }
  // Its exit code; −1 if it does not end.
  int end() {
    for (int waited = 0; !has_ended(); waited += 10) {
      if (waited > kPatience_ms) return -1;
      std::this_thread::sleep_for(10ms);
    }
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
  }
  std::string read_said() const {
    std::string text(1000, '\0');
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(read(said_, text.data(), text.size()), 0)));
    return text;
  }

 private:
  pid_t id_ = 0;
  int said_ = -1, status_ = 0;
  char ready_ = 0;
  bool ended_ = false;
};

int hang(const std::atomic<bool>&) {
  while (true) pause();
}

int wait_for_a_thread_that_computes(const std::atomic<bool>&) {
  std::thread([] {
    while (true) (void)get_processor_s();
  }).join();
  return 0;
}

int compute_a_report(const std::atomic<bool>& interrupted) {
  while (!interrupted.load()) std::this_thread::sleep_for(1ms);
  const double begun = get_processor_s();
  while (get_processor_s() - begun < kReport_s) {
  }
  return 7;
}

TEST(Sigterm, EndsWhatHangsBeforeAReportThatIsComputed) {
  Process report(compute_a_report), hanging(hang), waiting(wait_for_a_thread_that_computes);
  for (const Process* process : {&report, &hanging, &waiting}) process->terminate();
  EXPECT_EQ(hanging.end(), tools::kExitFailed);
  EXPECT_EQ(waiting.end(), tools::kExitFailed);
  EXPECT_FALSE(report.has_ended());
  EXPECT_NE(hanging.read_said().find("something hung"), std::string::npos);
  EXPECT_EQ(report.end(), 7) << "a report is never cut short";
  EXPECT_EQ(report.read_said(), "");
}

}  // namespace
}  // namespace unlatch::test
