// Messages that a run publishes: their numbers, ticks, limits, and their texts for people.
#include "hil/session/executive/publisher.h"

#include <gtest/gtest.h>

#include "hil/run/run.h"
#include "hil/session/executive/warm_up.h"
#include "tests/hil/session/fake_connection.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::publisher_test {
namespace {

using hil::MessageKind;
using hil::RunStatus;

class PublisherTest : public ::testing::Test {
 protected:
  void step() { ASSERT_EQ(simulation_->step().status, StepStatus::kOk); }

  const hil::Scenario scenario_ = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const std::unique_ptr<hil::Simulation> simulation_ = hil::build_simulation(scenario_);
  hil::Recorder recorder_{"", hil::LogHeader{}};
  FakeConnection connection_;
  hil::Publisher publisher_{*simulation_, recorder_, connection_, nullptr, 4711};
};

TEST_F(PublisherTest, AStateSentAgainKeepsItsNumber) {
  step();
  publisher_.publish_state(RunStatus::kRunning, 99);
  publisher_.resend_state(RunStatus::kPaused);
  publisher_.publish_state(RunStatus::kRunning, 99);
  ASSERT_EQ(connection_.sent.size(), 3u);
  EXPECT_EQ(connection_.sent[0].state.sequence, connection_.sent[1].state.sequence);
  EXPECT_EQ(connection_.sent[2].state.sequence, 1);
  EXPECT_EQ(connection_.sent[1].state.status, static_cast<std::int32_t>(RunStatus::kPaused));
  EXPECT_EQ(connection_.sent[1].state.hash, 99);
  EXPECT_EQ(connection_.sent[1].state.tick, 1);
  EXPECT_EQ(connection_.sent[1].state.session, 4711);
  EXPECT_EQ(publisher_.get_resent(), 1);
}

TEST_F(PublisherTest, ANoticeIsOfThisTickAndAnOverrunOfTheStepBefore) {
  step();
  publisher_.publish_notice("participant.joined", "fsw");
  hil::Overrun overrun;
  overrun.late_ns = 1'204'000;
  overrun.cause = hil::OverrunCause::kWarmUp;
  publisher_.publish_overrun(overrun);
  ASSERT_EQ(connection_.sent.size(), 2u);
  const hil::EventMessage &notice = connection_.sent[0].event, &late = connection_.sent[1].event;
  EXPECT_EQ(notice.tick, 1);
  EXPECT_EQ(notice.sequence, 0);
  EXPECT_EQ(late.tick, 0);
  EXPECT_EQ(late.sequence, 1);
  EXPECT_EQ(hil::get_name(late.name), "overrun.rehearsal") << "the name on the wire stays";
  EXPECT_EQ(hil::get_name(late.subject).substr(0, 12), "1204 us late");
  hil::EventMessage announced;
  EXPECT_TRUE(publisher_.take_notice(announced));
  EXPECT_EQ(hil::get_name(announced.subject), "fsw");
  EXPECT_FALSE(publisher_.take_notice(announced)) << "overruns are too many to be reported one by one";
}

TEST_F(PublisherTest, VerdictsAreLimitedWithinATick) {
  const auto publish = [this] { publisher_.publish_verdict(hil::Reject::kLate, "fsw", 7, 1, 0, 5); };
  for (int i = 0; i < 100; ++i) publish();
  EXPECT_EQ(connection_.sent.size(), static_cast<std::size_t>(hil::Publisher::kVerdictsPerTick))
      << "before the first tick";
  connection_.sent.clear();
  publisher_.begin_tick();
  for (int i = 0; i < 100; ++i) publish();
  EXPECT_EQ(connection_.sent.size(), static_cast<std::size_t>(hil::Publisher::kVerdictsPerTick));
  publisher_.begin_tick();
  publish();
  EXPECT_EQ(connection_.sent.back().verdict.sequence, 2 * hil::Publisher::kVerdictsPerTick);
  EXPECT_EQ(connection_.sent.back().verdict.applied_tick, 5);
}

TEST_F(PublisherTest, HealthAndReactionsHaveSessionNumberAndTime) {
  step();
  hil::HealthMessage health;
  health.late = 3;
  publisher_.publish_health(health);
  publisher_.publish_reactions();
  ASSERT_EQ(connection_.sent.size(), 2u);
  EXPECT_EQ(connection_.sent[0].health.late, 3);
  EXPECT_EQ(connection_.sent[0].health.time_ns, 1'000'000);
  EXPECT_EQ(connection_.sent[1].reactions.count, static_cast<std::int32_t>(kRows));
  EXPECT_NE(connection_.sent[1].reactions.multipliers[0], 0) << "the latch holds the pod";
}

// A clock that advances by the same amount with each reading.
class SteadyClock final : public hil::Clock {
 public:
  SteadyClock(std::int64_t at_ns, std::int64_t by_ns) : now_ns_(at_ns), by_ns_(by_ns) {}
  [[nodiscard]] std::int64_t get_ns() const noexcept override { return now_ns_ += by_ns_; }
  void sleep_until_ns(std::int64_t) const noexcept override {}

 private:
  mutable std::int64_t now_ns_;
  const std::int64_t by_ns_;
};

TEST(WarmUp, HasEndedAfterNothingBeforeItsFirst) {
  const hil::WarmUp warm_up;
  EXPECT_FALSE(warm_up.has_ended_after(-3'600'000'000'000)) << "a due time of long ago";
  EXPECT_FALSE(warm_up.has_ended_after(-1));
}

TEST(WarmUp, IsLeftOutWhenThereIsNotEnoughTime) {
  const auto simulation = hil::build_simulation(hil::load_scenario_text(kSessionScenario, "session.yaml"));
  const SteadyClock clock(-100, 10);
  hil::WarmUp warm_up;
  warm_up.run(*simulation, clock, 1'000'000);  // ends at -80, takes 10
  EXPECT_TRUE(warm_up.has_ended_after(-81));
  EXPECT_FALSE(warm_up.has_ended_after(-80));
  warm_up.run(*simulation, clock, 15);
  EXPECT_FALSE(warm_up.has_ended_after(-80)) << "15 ns left, one and a half times 10 needed";
  warm_up.run(*simulation, clock, 16);  // the estimate was halved: ends at -60
  EXPECT_TRUE(warm_up.has_ended_after(-61));
  EXPECT_EQ(simulation->get_tick(), 0);
}

}  // namespace
}  // namespace unlatch::test::publisher_test
