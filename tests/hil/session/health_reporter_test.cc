// Health, Reactions and counts of a run; on any clock, also one that has just begun.
#include "hil/session/executive/health_reporter.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/hil/session/fake_connection.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::health_reporter_test {
namespace {

using hil::MessageKind;

constexpr std::int64_t kMs = 1'000'000;  // ns

// The parameter: the clock's reading at the beginning.
class HealthReporterTest : public ::testing::TestWithParam<std::int64_t> {
 protected:
  [[nodiscard]] std::int64_t at(std::int64_t ns) const { return GetParam() + ns; }
  [[nodiscard]] std::int64_t count(MessageKind kind) const {
    const std::vector<MessageKind> kinds = connection_.list_kinds();
    return std::count(kinds.begin(), kinds.end(), kind);
  }

  const hil::Scenario scenario_ = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const std::unique_ptr<hil::Simulation> simulation_ = hil::build_simulation(scenario_);
  hil::Recorder recorder_{"", hil::LogHeader{}};
  FakeConnection connection_;
  hil::Timing timing_;
  hil::Participants participants_{{"fsw"}};
  hil::RejectCounts rejects_;
  hil::CommandQueue commands_{simulation_->model().channels, {.session = 4711}, participants_, rejects_};
  hil::Publisher publisher_{*simulation_, recorder_, connection_, nullptr, 4711};
  hil::Liveness liveness_{participants_, hil::Policy::kHold, kMs};
  hil::HealthReporter health_{{.timing = timing_,
                               .participants = participants_,
                               .commands = commands_,
                               .rejects = rejects_,
                               .connection = connection_,
                               .liveness = liveness_},
                              publisher_};
};

TEST_P(HealthReporterTest, HealthComesOnceASecondAndReactionsTenTimes) {
  health_.begin_run(at(0));
  for (std::int64_t ms = 1; ms <= 3000; ++ms) health_.publish_due(at(ms * kMs));
  EXPECT_EQ(count(MessageKind::kHealth), 3);
  EXPECT_EQ(count(MessageKind::kReactions), 30);
  EXPECT_EQ(connection_.sent.front().kind, MessageKind::kReactions) << "the first at once";
}

TEST_P(HealthReporterTest, WallTimeCountsFromTheBeginningOfTheRun) {
  health_.publish_health(at(5));
  EXPECT_EQ(connection_.sent.back().health.wall_ns, 0) << "it could not start";
  health_.begin_run(at(10));
  health_.publish_health(at(30));
  EXPECT_EQ(connection_.sent.back().health.wall_ns, 20);
}

TEST_P(HealthReporterTest, HealthAndTheSummaryHaveTheCountsOfAllParts) {
  timing_.step.record(700);
  timing_.slipped_ns = 11;
  timing_.skipped_outputs = 2;
  rejects_.add(hil::Reject::kDuplicate, 4);
  publisher_.set_resent(5);
  liveness_.begin_round(0, at(0));
  liveness_.begin_round(1, at(kMs));
  health_.publish_health(at(0));
  const hil::HealthMessage& health = connection_.sent.back().health;
  EXPECT_EQ(health.step_max_ns, 700);
  EXPECT_EQ(health.missing, 1) << "the flight software has not introduced itself";
  EXPECT_EQ(health.rejected[static_cast<std::size_t>(hil::Reject::kDuplicate)], 4);
  EXPECT_EQ(health.resent, 5);
  const hil::TimingSummary summary = health_.summarize(0);
  EXPECT_EQ(summary.step.max, 700);
  EXPECT_EQ(summary.slipped_ns, 11);
  EXPECT_EQ(summary.skipped_outputs, 2);
  EXPECT_EQ(summary.rejected[static_cast<std::size_t>(hil::Reject::kDuplicate)], 4);
  EXPECT_EQ(summary.resent, 5);
  EXPECT_EQ(summary.unanswered, 1);
}

INSTANTIATE_TEST_SUITE_P(Clocks, HealthReporterTest, testing::Values(-3'600'000 * kMs, -500 * kMs, -1, 0, 1));

}  // namespace
}  // namespace unlatch::test::health_reporter_test
