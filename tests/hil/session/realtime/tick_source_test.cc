// Tick sources of the cyclic thread: the clock, and descriptors from outside. No fact depends on delays.
#include "hil/session/realtime/tick_source.h"

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "hil/session/realtime/clock.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::tick_source_test {
namespace {

using hil::DescriptorTicks;
using hil::MonotonicTicks;
using hil::Pace;
using hil::RunStatus;

constexpr std::int64_t kMs = 1'000'000;           // ns
constexpr std::int64_t kPatience = 30'000 * kMs;  // beyond any stall of the machine

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) { EXPECT_GE(fd, 0); }
  ~Descriptor() { close_now(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void close_now() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

void add_ticks(const Descriptor& descriptor, std::uint64_t count) {
  ASSERT_EQ(write(descriptor.get(), &count, sizeof count), static_cast<ssize_t>(sizeof count));
}

TEST(MonotonicTicks, AnHourAtOneKilohertzDoesNotDriftByANanosecond) {
  constexpr std::int64_t kTicks = 3'600'000;
  MonotonicTicks ticks(kMs, 0);
  const std::int64_t start_ns = hil::get_monotonic_ns() - (kTicks + 1) * kMs;  // all are due already: no waiting
  std::atomic<bool> stop{false};
  ticks.restart(start_ns);
  for (std::int64_t i = 0; i < kTicks; ++i) ASSERT_TRUE(ticks.wait(stop));
  EXPECT_EQ(ticks.get_due_ns(), start_ns + kTicks * kMs);
  EXPECT_TRUE(ticks.is_backlogged());
}

TEST(MonotonicTicks, NeverWakesEarlyAsleepOrSpinning) {
  for (const std::int64_t spin_ns : {std::int64_t{0}, kMs / 2, 2 * kMs}) {
    MonotonicTicks ticks(kMs, spin_ns);
    std::atomic<bool> stop{false};
    const std::int64_t start_ns = hil::get_monotonic_ns();
    ticks.restart(start_ns);
    for (int i = 1; i <= 20; ++i) {
      ASSERT_TRUE(ticks.wait(stop));
      EXPECT_EQ(ticks.get_due_ns(), start_ns + i * kMs);
      EXPECT_GE(ticks.get_awake_ns(), ticks.get_due_ns());
      EXPECT_GE(hil::get_monotonic_ns(), ticks.get_due_ns());
      EXPECT_EQ(ticks.get_latency_ns(), ticks.get_awake_ns() - ticks.get_due_ns());
    }
  }
}

TEST(MonotonicTicks, DozeUntilTheSpinAndCountALateWakeUpAsLatency) {
  MonotonicTicks ticks(kMs, kMs / 2);
  std::atomic<bool> stop{false};
  ticks.restart(hil::get_monotonic_ns());
  const std::int64_t left_ns = ticks.doze();
  EXPECT_LE(left_ns, kMs / 2);
  hil::sleep_until_ns(ticks.get_next_due_ns() + 1000);  // work in between took too long
  ASSERT_TRUE(ticks.wait(stop));
  EXPECT_FALSE(ticks.is_backlogged());
  EXPECT_GE(ticks.get_latency_ns(), 1000);
  hil::sleep_until_ns(ticks.get_next_due_ns());
  EXPECT_EQ(ticks.doze(), 0) << "the next tick is due";
  ASSERT_TRUE(ticks.wait(stop));
  EXPECT_TRUE(ticks.is_backlogged());
}

TEST(MonotonicTicks, WithoutSpinThereIsNothingToDozeFor) {
  MonotonicTicks ticks(kMs, 0);
  ticks.restart(hil::get_monotonic_ns());
  EXPECT_EQ(ticks.doze(), 0);
}

TEST(MonotonicTicks, KnowHowFarTheyAreBehindAndSlipByExactlyWhatWasLost) {
  MonotonicTicks ticks(kMs, 0);
  std::atomic<bool> stop{false};
  ticks.restart(hil::get_monotonic_ns() - 10 * kMs);
  ASSERT_TRUE(ticks.wait(stop));
  const std::int64_t due_ns = ticks.get_due_ns(), now_ns = due_ns + 5 * kMs + 7;
  EXPECT_EQ(ticks.calc_behind(now_ns), 5);
  EXPECT_EQ(ticks.slip(now_ns), 5 * kMs + 7);
  EXPECT_EQ(ticks.calc_behind(now_ns), 0);
  EXPECT_EQ(ticks.get_next_due_ns(), now_ns + kMs);
}

TEST(DescriptorTicks, AnEventfdsCountIsSoManyTicks) {
  const Descriptor event(eventfd(0, 0));
  DescriptorTicks ticks(event.get(), kMs, kPatience);
  std::atomic<bool> stop{false};
  ticks.restart(hil::get_monotonic_ns());
  add_ticks(event, 3);
  ASSERT_TRUE(ticks.wait(stop));
  EXPECT_FALSE(ticks.is_backlogged());
  EXPECT_EQ(ticks.calc_behind(0), 2);
  EXPECT_EQ(ticks.get_latency_ns(), 2 * kMs) << "the last of the three is due when it is seen";
  const std::int64_t due_ns = ticks.get_due_ns();
  ASSERT_TRUE(ticks.wait(stop));
  EXPECT_TRUE(ticks.is_backlogged());
  EXPECT_EQ(ticks.get_due_ns(), due_ns + kMs);
  EXPECT_EQ(ticks.slip(hil::get_monotonic_ns()), kMs);
  EXPECT_EQ(ticks.calc_behind(0), 0);
}

TEST(DescriptorTicks, ATimerfdTicksWithThePeriodThatItWasGiven) {
  const Descriptor timer(timerfd_create(CLOCK_MONOTONIC, 0));
  const itimerspec every{{0, 2 * kMs}, {0, 2 * kMs}};
  ASSERT_EQ(timerfd_settime(timer.get(), 0, &every, nullptr), 0);
  DescriptorTicks ticks(timer.get(), 2 * kMs, kPatience);
  std::atomic<bool> stop{false};
  const std::int64_t start_ns = hil::get_monotonic_ns();
  ticks.restart(start_ns);
  constexpr int kTicks = 20;
  for (int i = 0; i < kTicks; ++i) ASSERT_TRUE(ticks.wait(stop));
  // The first one may have been due just before the start.
  EXPECT_GE(hil::get_monotonic_ns() - start_ns, (kTicks - 1) * 2 * kMs - 2 * kMs);
}

TEST(DescriptorTicks, EveryByteOfAPipeIsATick) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const Descriptor out(ends[0]);
  Descriptor in(ends[1]);
  DescriptorTicks ticks(out.get(), kMs, kPatience);
  std::atomic<bool> stop{false};
  ticks.restart(hil::get_monotonic_ns());
  ASSERT_EQ(write(in.get(), "....", 4), 4);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(ticks.wait(stop));
  in.close_now();
  EXPECT_FALSE(ticks.wait(stop));
  EXPECT_STREQ(ticks.get_failure(), "its other end was closed");
}

TEST(DescriptorTicks, SilenceIsAFailureAndAStopIsNone) {
  const Descriptor event(eventfd(0, 0));
  std::atomic<bool> stop{false};
  DescriptorTicks silent(event.get(), kMs, 20 * kMs);
  EXPECT_FALSE(silent.wait(stop));
  EXPECT_STREQ(silent.get_failure(), "it is silent");
  stop = true;
  DescriptorTicks stopped(event.get(), kMs, kPatience);
  EXPECT_FALSE(stopped.wait(stop));
  EXPECT_STREQ(stopped.get_failure(), "");
  DescriptorTicks none(-1, kMs, kPatience);
  EXPECT_FALSE(none.wait(stop));
  EXPECT_STREQ(none.get_failure(), "it is no open descriptor");
}

TEST(Realtime, IsPacedByAnEventfdAndReplays) {
  const Descriptor event(eventfd(0, 0));
  std::jthread pulse([&event](const std::stop_token& stopping) {
    while (!stopping.stop_requested()) {
      add_ticks(event, 1);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  });
  const std::string log = make_path("log");
  DescriptorTicks ticks(event.get(), kMs, kPatience);
  const SessionResult result = run_session(Pace::kRealtime, {}, log, {"flight_software.timeout=10"}, true, &ticks);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(result.end.timing.wakeup.count, 50);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Realtime, ATickSourceThatFailsEndsTheRunAndIsNamed) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const Descriptor out(ends[0]);
  Descriptor in(ends[1]);
  DescriptorTicks ticks(out.get(), kMs, kPatience);
  std::jthread pulse([&in] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ASSERT_EQ(write(in.get(), "...", 3), 3);
    in.close_now();
  });
  const SessionResult result = run_session(Pace::kRealtime, {}, "", {"flight_software.timeout=10"}, true, &ticks);
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_EQ(result.end.message, "the tick source has failed: its other end was closed");
}

}  // namespace
}  // namespace unlatch::test::tick_source_test
