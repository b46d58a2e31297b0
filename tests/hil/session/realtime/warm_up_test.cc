// A warm-up step before each tick changes nothing but the time.
#include <gtest/gtest.h>

#include "hil/session/realtime/clock.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::warm_up_test {
namespace {

using hil::Pace;
using hil::RunStatus;

const char* const kRates =
    "timing={spin: 500 us, states: {every: 5, phase: 2}, groups: {nav: {every: 4, sensors: [gyro]}, "
    "drive: {period: 10 ms, phase: 3, elements: [engine]}}}";

std::unique_ptr<hil::Simulation> build() {
  return hil::build_simulation(hil::load_scenario_text(kSessionScenario, "session.yaml", {kRates}));
}

TEST(WarmUp, LeavesNothingBehind) {
  const auto warmed = build(), plain = build();
  for (int tick = 0; tick < 60; ++tick) {
    for (hil::Simulation* simulation : {warmed.get(), plain.get()}) simulation->channels()[0] = 0.2 + 0.01 * tick;
    warmed->warm_up();
    ASSERT_EQ(warmed->save(), plain->save()) << "before tick " << tick;
    ASSERT_EQ(warmed->step().status, StepStatus::kOk);
    ASSERT_EQ(plain->step().status, StepStatus::kOk);
    ASSERT_EQ(warmed->save(), plain->save()) << "tick " << tick;
    warmed->warm_up();
    for (std::size_t i = 0; i < plain->workspace().multipliers.size(); ++i)
      ASSERT_EQ(warmed->workspace().multipliers[i], plain->workspace().multipliers[i]) << "tick " << tick;
  }
}

TEST(WarmUp, OfEveryTickOfASessionReplays) {
  const std::string log = make_path("log");
  const SessionResult result = run_session(Pace::kRealtime, {}, log, {kRates, "flight_software.timeout=30"});
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_TRUE(replay_log(log).result.agrees());
}

// Ticks without waiting, with an hour for a warm-up step before each; they end after some.
class EndingTicks final : public hil::TickSource {
 public:
  explicit EndingTicks(std::int64_t count) : TickSource(1'000'000), left_(count) {}
  void restart(std::int64_t) noexcept override {}
  std::int64_t doze() noexcept override { return kHour_ns; }
  bool wait(const std::atomic<bool>&) noexcept override {
    awake_ns_ = hil::get_monotonic_ns();
    due_ns_ = awake_ns_ + kHour_ns;
    return left_-- > 0;
  }
  std::int64_t slip(std::int64_t) noexcept override { return 0; }
  std::int64_t calc_behind(std::int64_t) const noexcept override { return 0; }

 private:
  static constexpr std::int64_t kHour_ns = 3'600'000'000'000;
  std::int64_t left_;
};

// The run ends after a warm-up step of the tick that never comes, in which the latch, held until then, is free.
TEST(WarmUp, LastReactionsAreThoseOfTheLastTick) {
  constexpr int kTicks = 20;
  const auto warmed = build(), plain = build();
  EndingTicks ticks(kTicks);
  hil::ExecutiveOptions options;
  options.pace = Pace::kRealtime;
  options.last_tick = 2 * kTicks;
  options.ticks = &ticks;
  hil::RingConnection connection(256, 256);
  hil::Recorder recorder("", hil::LogHeader{});
  const hil::LogEnd end = hil::Executive(*warmed, connection, recorder, "session", options).run();
  ASSERT_EQ(end.tick, kTicks);
  hil::Message message;
  hil::ReactionsMessage reactions;
  while (connection.take(message)) {
    if (message.kind == hil::MessageKind::kReactions) reactions = message.reactions;
  }
  ASSERT_EQ(reactions.tick, kTicks);
  EXPECT_NE(reactions.multipliers[0], 0);
  for (int tick = 0; tick < kTicks; ++tick) ASSERT_EQ(plain->step().status, StepStatus::kOk);
  for (std::size_t row = 0; row < kRows; ++row)
    EXPECT_EQ(reactions.multipliers[row], plain->workspace().multipliers[row]) << "row " << row;
}

// Ticks that become due during the warm-up step.
class OvertakenTicks final : public hil::TickSource {
 public:
  OvertakenTicks() : TickSource(1'000'000) {}
  void restart(std::int64_t) noexcept override {}
  std::int64_t doze() noexcept override {
    due_ns_ = hil::get_monotonic_ns();
    return 3'600'000'000'000;
  }
  bool wait(const std::atomic<bool>&) noexcept override {
    awake_ns_ = hil::get_monotonic_ns() + 10'000'000;
    latency_ns_ = awake_ns_ - due_ns_;
    due_ns_ -= period_ns_;  // the next one is due as well
    return true;
  }
  std::int64_t slip(std::int64_t) noexcept override { return 0; }
  std::int64_t calc_behind(std::int64_t) const noexcept override { return 0; }
};

TEST(WarmUp, ThatMakesATickLateIsNamedAsTheCause) {
  constexpr int kTicks = 5;
  const auto simulation = build();
  OvertakenTicks ticks;
  hil::ExecutiveOptions options;
  options.pace = Pace::kRealtime;
  options.last_tick = kTicks;
  options.ticks = &ticks;
  hil::RingConnection connection(256, 256);
  hil::Recorder recorder("", hil::LogHeader{});
  const hil::LogEnd end = hil::Executive(*simulation, connection, recorder, "session", options).run();
  EXPECT_EQ(end.timing.overruns, kTicks);
  EXPECT_EQ(end.timing.overrun_causes[static_cast<std::size_t>(hil::OverrunCause::kWarmUp)], kTicks);
}

}  // namespace
}  // namespace unlatch::test::warm_up_test
