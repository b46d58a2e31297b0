#include "bridge/pump.h"

#include <sys/prctl.h>

#include <chrono>

namespace unlatch::bridge {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

// The cyclic thread makes no system call to wake us, so the out ring is looked at again and again: at once while an
// answer in lockstep is likely, often enough for 1 kHz while the run goes on, and seldom when it rests.
constexpr auto kSpinFor = 100us;
constexpr auto kAwakeFor = 100ms;
constexpr auto kShortSleep = 20us;
constexpr auto kLongSleep = 1ms;

// How long the in thread may take to see that it shall stop.
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

Pump::Pump(hil::Link& link, Port& port)
    : link_(link),
      port_(port),
      out_([this](const std::stop_token& stopping) { run_out(stopping); }),
      in_([this](const std::stop_token& stopping) { run_in(stopping); }) {}

Pump::~Pump() { stop(); }

void Pump::stop() {
  out_.request_stop();
  in_.request_stop();
  if (out_.joinable()) out_.join();
  if (in_.joinable()) in_.join();
}

void Pump::run_out(const std::stop_token& stopping) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // else short sleeps last 50 us longer
  Message message;
  auto last_message = Clock::now();
  while (true) {
    const bool last_look =
        stopping.stop_requested();  // asked before looking, so that nothing sent before stop() is left behind
    if (link_.take(message)) {
      port_.publish(message);
      last_message = Clock::now();
    } else if (last_look) {
      return;
    } else {
      wait_since(last_message);
    }
  }
}

void Pump::run_in(const std::stop_token& stopping) {
  Message message;
  while (!stopping.stop_requested()) {
    if (port_.poll(message, kPollWait)) link_.deliver(message);
    link_.set_malformed(port_.get_malformed());
  }
}

}  // namespace unlatch::bridge
