// A machine that has just been started: its clock reads small, zero, or (relative to due times) negative values. A
// session there is the same as on any other machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "hil/session/faults/fault_injector.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::fresh_boot_test {
namespace {

using hil::OverrunCause;
using hil::Pace;
using hil::RunStatus;

constexpr std::int64_t kMs = 1'000'000;  // ns
const char* const kPatient = "flight_software.timeout=30";

// The monotonic clock with another origin.
class ShiftedClock final : public hil::Clock {
 public:
  explicit ShiftedClock(std::int64_t reads_ns) : shift_ns_(reads_ns - hil::get_monotonic_ns()) {}
  [[nodiscard]] std::int64_t get_ns() const noexcept override { return hil::get_monotonic_ns() + shift_ns_; }
  void sleep_until_ns(std::int64_t deadline_ns) const noexcept override {
    hil::sleep_until_ns(deadline_ns - shift_ns_);
  }

 private:
  const std::int64_t shift_ns_;
};

// Ticks without waiting; those in `late` are an hour late, all others have an hour left.
class ScriptedTicks final : public hil::TickSource {
 public:
  ScriptedTicks(const hil::Clock& clock, std::set<std::int64_t> late)
      : TickSource(kMs), clock_(clock), late_(std::move(late)) {}
  void restart(std::int64_t) noexcept override {}
  bool wait(const std::atomic<bool>& stop) noexcept override {
    const bool late = late_.count(next_++) > 0;
    awake_ns_ = clock_.get_ns();
    due_ns_ = late ? awake_ns_ - kHour_ns : awake_ns_ + kHour_ns;
    latency_ns_ = late ? kHour_ns : 0;
    return !stop;
  }
  std::int64_t slip(std::int64_t) noexcept override { return 0; }
  std::int64_t calc_behind(std::int64_t) const noexcept override { return 0; }

 private:
  static constexpr std::int64_t kHour_ns = 3'600'000 * kMs;
  const hil::Clock& clock_;
  const std::set<std::int64_t> late_;
  std::int64_t next_ = 0;
};

// The parameter: the clock's reading at the beginning: an hour before 0, near it (sessions last longer than 30 ms),
// behind it.
class FreshBoot : public ::testing::TestWithParam<std::int64_t> {
 protected:
  const ShiftedClock clock_{GetParam()};
};

TEST_P(FreshBoot, AnOverrunHasItsCause) {
  ScriptedTicks ticks(clock_, {3, 17, 49});
  const SessionResult result = run_session(Pace::kRealtime, {}, "", {kPatient}, true, &ticks, nullptr, clock_);
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(result.end.timing.overruns, 3);
  EXPECT_EQ(result.end.timing.overrun_causes[static_cast<std::size_t>(OverrunCause::kLateWakeup)], 3);
}

TEST_P(FreshBoot, ASessionHasTheSameBitsAndTimes) {
  static const std::int64_t reference = run_session(Pace::kLockstep, {}).end.hash;
  const SessionResult result = run_session(Pace::kLockstep, {}, "", {kPatient}, true, nullptr, nullptr, clock_);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(result.end.hash, reference);
  EXPECT_EQ(result.end.timing.round_trip.count, 50);
  EXPECT_EQ(result.end.timing.turnaround.count, 7);
}

TEST_P(FreshBoot, TheClockPacesTheTicks) {
  const std::int64_t begin_ns = clock_.get_ns();
  const SessionResult result = run_session(Pace::kRealtime, {}, "", {kPatient}, true, nullptr, nullptr, clock_);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_GE(clock_.get_ns() - begin_ns, 50 * kMs);
  EXPECT_EQ(result.end.timing.wakeup.count, 50);
}

TEST_P(FreshBoot, ASilentParticipantMeetsThePolicyAndAPauseEnds) {
  FakeParticipant::Habits habits;
  habits.dies_at = 12;
  habits.returns_after = std::chrono::milliseconds(100);
  const SessionResult result =
      run_session(Pace::kLockstep, habits, "", {"flight_software.policy=pause", "flight_software.timeout=0.02"}, true,
                  nullptr, nullptr, clock_);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_THAT(result.notices, testing::Contains("policy.pause"));
}

// It has sent no command before, so that nothing was heard of it since the State.
TEST_P(FreshBoot, ADroppedStateIsSentAgain) {
  FakeParticipant::Habits habits;
  habits.deaf_at = 0;
  habits.deaf_times = 3;
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {kPatient}, true, nullptr, nullptr, clock_);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(result.end.tick, 50);
}

INSTANTIATE_TEST_SUITE_P(Readings, FreshBoot, testing::Values(-3'600'000 * kMs, -20 * kMs, -1, 0, 1, 20 * kMs));

}  // namespace
}  // namespace unlatch::test::fresh_boot_test
