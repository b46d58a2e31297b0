// Messages from participants: the part that each goes to, the cut-off, refusals; on any clock.
#include <gtest/gtest.h>

#include "hil/session/executive/session.h"
#include "tests/hil/session/fake_connection.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::session_reception_test {
namespace {

using hil::MessageKind;
using hil::Reject;

// The parameter: the clock's reading at the beginning.
class SessionReceptionTest : public ::testing::TestWithParam<std::int64_t> {
 protected:
  SessionReceptionTest() {
    options_.pace = hil::Pace::kRealtime;
    options_.session = 4711;
    options_.flight_software.required = {"fsw"};
    options_.flight_software.timeout = 1;
    options_.clock = &clock_;
    session_.emplace(*simulation_, connection_, recorder_, "session", options_, heartbeat_, round_trip_);
  }
  [[nodiscard]] std::int64_t at(std::int64_t ns) const { return GetParam() + ns; }
  void arrive(const hil::ParticipantMessage& message, std::int64_t arrived_ns) {
    connection_.arrivals.push_back({message, arrived_ns});
    session_->receive();
  }
  void join() {
    hil::HelloAckMessage answer = make_hello_ack();
    answer.model_hash = simulation_->get_model_hash();
    arrive(answer, at(0));
  }
  hil::Participant& fsw() { return *session_->participants().find("fsw"); }
  [[nodiscard]] std::int64_t count(Reject reason) const {
    return session_->rejects().by_reason[static_cast<std::size_t>(reason)];
  }
  std::vector<double> take_due(std::int64_t tick) {
    std::vector<double> values;
    session_->commands().take_due(
        tick, [&](const hil::CommandQueue::Pending& pending) { values.push_back(pending.command.value); });
    return values;
  }

  const hil::Scenario scenario_ = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const std::unique_ptr<hil::Simulation> simulation_ = hil::build_simulation(scenario_);
  hil::Recorder recorder_{"", hil::LogHeader{}};
  FakeConnection connection_;
  ManualClock clock_{GetParam()};
  hil::ExecutiveOptions options_;
  hil::Heartbeat heartbeat_;
  hil::Histogram round_trip_;
  std::optional<hil::Session> session_;
};

TEST_P(SessionReceptionTest, AnIntroductionIsAnnouncedOnce) {
  join();
  join();
  EXPECT_TRUE(fsw().is_present());
  EXPECT_EQ(connection_.list_kinds(), std::vector<MessageKind>{MessageKind::kEvent});
}

TEST_P(SessionReceptionTest, ACommandWaitsForItsTickAndIsNewsOfItsSender) {
  join();
  EXPECT_FALSE(fsw().news_ns);
  arrive(make_command(1, 0, 0.8), at(7));
  EXPECT_EQ(fsw().news_ns, at(7));
  EXPECT_EQ(session_->get_command_ns(), at(7));
  arrive(make_command(1, 0, 0.8), at(9));
  EXPECT_EQ(fsw().news_ns, at(7)) << "a duplicate is no news";
  EXPECT_EQ(take_due(0), std::vector<double>{0.8});
}

TEST_P(SessionReceptionTest, ACommandAfterTheCutoffIsForTheNextTick) {
  join();
  session_->set_cutoff(at(10));
  arrive(make_command(1, 0, 0.6), at(10));
  arrive(make_command(2, 0, 0.7), at(11));
  EXPECT_EQ(take_due(0), std::vector<double>{0.6});
  EXPECT_EQ(take_due(1), std::vector<double>{0.7});
  EXPECT_EQ(session_->commands().get_late(), 1);
  EXPECT_EQ(connection_.sent.back().verdict.reason, static_cast<std::int32_t>(Reject::kLate));
}

TEST_P(SessionReceptionTest, ARefusedCommandIsAnsweredAndCounted) {
  join();
  arrive(make_command(1, 0, 5), at(1));
  ASSERT_EQ(connection_.sent.back().kind, MessageKind::kVerdict);
  EXPECT_EQ(connection_.sent.back().verdict.reason, static_cast<std::int32_t>(Reject::kOutOfRange));
  EXPECT_EQ(count(Reject::kOutOfRange), 1);
}

TEST_P(SessionReceptionTest, AnAnswerThatCannotBeIsRefused) {
  join();
  arrive(make_step_ack(1), at(1));  // the simulation is at tick 0
  EXPECT_EQ(count(Reject::kMalformed), 1);
  arrive(make_step_ack(0, 99), at(1));
  EXPECT_EQ(count(Reject::kUnknownParticipant), 1);
  EXPECT_FALSE(fsw().has_answered(0));
  arrive(make_step_ack(0), at(2));
  EXPECT_TRUE(fsw().has_answered(0));
}

TEST_P(SessionReceptionTest, AMessageOfALostParticipantBringsItBack) {
  join();
  (void)session_->liveness().lose(fsw());
  arrive(make_step_ack(0), at(5));
  EXPECT_TRUE(fsw().is_present());
  EXPECT_EQ(hil::get_name(connection_.sent.back().event.name), "participant.resumed");
}

TEST_P(SessionReceptionTest, AnotherSimulatorIsNoticedUnlessItsSessionIsOver) {
  hil::HelloMessage other;
  other.session = 4712;
  other.status = static_cast<std::int32_t>(hil::RunStatus::kDone);
  arrive(other, at(0));
  EXPECT_EQ(session_->get_other().session, 0);
  other.status = static_cast<std::int32_t>(hil::RunStatus::kRunning);
  arrive(other, at(0));
  arrive(other, at(0));
  EXPECT_EQ(session_->get_other().session, 4712);
  EXPECT_EQ(connection_.sent.size(), 1u) << "reported once";
  EXPECT_FALSE(session_->is_number_taken());
}

TEST_P(SessionReceptionTest, AnotherSimulatorWithOurSessionNumberIsNoticedAndCountsMoreThanOthers) {
  hil::HelloMessage other;
  other.session = 4711;
  arrive(other, at(0));
  other.session = 4712;
  arrive(other, at(0));
  EXPECT_TRUE(session_->is_number_taken());
  EXPECT_EQ(session_->get_other().session, 4711);
  EXPECT_EQ(connection_.list_kinds(), (std::vector<MessageKind>{MessageKind::kEvent, MessageKind::kEvent}));
}

TEST_P(SessionReceptionTest, EachOtherSimulatorIsReportedOnceAndInventedOnesAreNotReportedForEver) {
  hil::HelloMessage other;
  for (int round = 0; round < 3; ++round) {
    for (other.session = 1; other.session <= 2; ++other.session) arrive(other, at(0));
  }
  EXPECT_EQ(connection_.sent.size(), 2u);
  for (; other.session <= 1000; ++other.session) arrive(other, at(0));
  EXPECT_EQ(connection_.sent.size(), 8u);
}

INSTANTIATE_TEST_SUITE_P(Clocks, SessionReceptionTest, testing::Values(-1'000'000, -9, 0, 1'000'000));

}  // namespace
}  // namespace unlatch::test::session_reception_test
