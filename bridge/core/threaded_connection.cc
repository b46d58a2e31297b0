#include "bridge/core/threaded_connection.h"

#include <sys/prctl.h>

#include <chrono>

namespace unlatch::bridge {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

// The cyclic thread makes no system call to wake this one, which polls the out ring: without sleep while an answer in
// lockstep is likely, often enough for 1 kHz while the run goes on, and seldom when it rests.
constexpr auto kSpinFor = 100us;
constexpr auto kAwakeFor = 100ms;
constexpr auto kShortSleep = 20us;
constexpr auto kLongSleep = 1ms;

// The longest time until the in thread sees that it shall stop.
constexpr auto kPollWait = 20ms;

void wait_since(Clock::time_point last_message) {
  const auto idle = Clock::now() - last_message;
  if (idle < kSpinFor) {
    std::this_thread::yield();
  } else {
    std::this_thread::sleep_for(idle < kAwakeFor ? kShortSleep : kLongSleep);
  }
}

}  // namespace

ThreadedConnection::ThreadedConnection(Port& port, std::size_t out_capacity, std::size_t in_capacity,
                                       const hil::Clock& clock)
    : RingConnection(out_capacity, in_capacity, clock),
      port_(port),
      out_thread_([this](const std::stop_token& stopping) { run_out(stopping); }),
      in_thread_([this](const std::stop_token& stopping) { run_in(stopping); }) {}

ThreadedConnection::~ThreadedConnection() { stop(); }

void ThreadedConnection::stop() {
  out_thread_.request_stop();
  in_thread_.request_stop();
  if (out_thread_.joinable()) out_thread_.join();
  if (in_thread_.joinable()) in_thread_.join();
}

void ThreadedConnection::run_out(const std::stop_token& stopping) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // else short sleeps last 50 us longer
  Message message;
  auto last_message = Clock::now();
  while (true) {
    const bool last_look =
        stopping.stop_requested();  // asked before looking, so that nothing sent before stop() is left behind
    if (take(message)) {
      port_.publish(message);
      last_message = Clock::now();
    } else if (last_look) {
      return;
    } else {
      wait_since(last_message);
    }
  }
}

void ThreadedConnection::run_in(const std::stop_token& stopping) {
  Message message;
  while (!stopping.stop_requested()) {
    if (port_.poll(message, kPollWait)) {
      if (const auto received = hil::to_participant_message(message)) deliver(*received);
    }
    set_malformed(port_.get_malformed());
  }
}

}  // namespace unlatch::bridge
