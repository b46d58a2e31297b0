// Messages from participants: the part that each goes to, the cut-off, refusals; on any clock.
#include "hil/session/executive/reception.h"

#include <gtest/gtest.h>

#include "tests/hil/fake_connection.h"
#include "tests/hil/session_support.h"

namespace unlatch::test {
namespace {

using hil::MessageKind;
using hil::Reject;

// The parameter: the clock's reading at the beginning.
class ReceptionTest : public ::testing::TestWithParam<std::int64_t> {
 protected:
  ReceptionTest() {
    hello_.session = 4711;
    hello_.schema_hash = hil::kSchemaHash;
    hello_.model_hash = 1;
    hello_.dt_ns = 1'000'000;
    hello_.protocol = hil::kProtocolVersion;
    handshake_.emplace(hello_, participants_);
    reception_.emplace(hil::Reception::Parts{.connection = connection_,
                                             .simulation = *simulation_,
                                             .clock = clock_,
                                             .participants = participants_,
                                             .handshake = *handshake_,
                                             .liveness = liveness_,
                                             .commands = commands_,
                                             .rejects = rejects_,
                                             .publisher = publisher_,
                                             .heartbeat = heartbeat_,
                                             .session = 4711});
  }
  [[nodiscard]] std::int64_t at(std::int64_t ns) const { return GetParam() + ns; }
  void arrive(const hil::ParticipantMessage& message, std::int64_t arrived_ns) {
    connection_.arrivals.push_back({message, arrived_ns});
    reception_->receive();
  }
  void join() { arrive(make_hello_ack(), at(0)); }
  hil::Participant& fsw() { return *participants_.find("fsw"); }
  [[nodiscard]] std::int64_t count(Reject reason) const { return rejects_.by_reason[static_cast<std::size_t>(reason)]; }
  std::vector<double> take_due(std::int64_t tick) {
    std::vector<double> values;
    commands_.take_due(tick,
                       [&](const hil::CommandQueue::Pending& pending) { values.push_back(pending.command.value); });
    return values;
  }

  const hil::Scenario scenario_ = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const std::unique_ptr<hil::Simulation> simulation_ = hil::build_simulation(scenario_);
  hil::Recorder recorder_{"", hil::LogHeader{}};
  FakeConnection connection_;
  ManualClock clock_{GetParam()};
  hil::HelloMessage hello_;
  hil::Participants participants_{{"fsw"}};
  std::optional<hil::Handshake> handshake_;
  hil::Liveness liveness_{participants_, hil::Policy::kHold, 1'000'000'000};
  hil::RejectCounts rejects_;
  hil::CommandQueue commands_{
      simulation_->model().channels, {.session = 4711, .accept_late = true}, participants_, rejects_};
  hil::Publisher publisher_{*simulation_, recorder_, connection_, nullptr, 4711};
  hil::Heartbeat heartbeat_;
  std::optional<hil::Reception> reception_;
};

TEST_P(ReceptionTest, AnIntroductionIsAnnouncedOnce) {
  join();
  join();
  EXPECT_TRUE(fsw().is_present());
  EXPECT_EQ(connection_.list_kinds(), std::vector<MessageKind>{MessageKind::kEvent});
}

TEST_P(ReceptionTest, ACommandWaitsForItsTickAndIsNewsOfItsSender) {
  join();
  EXPECT_FALSE(fsw().news_ns);
  arrive(make_command(1, 0, 0.8), at(7));
  EXPECT_EQ(fsw().news_ns, at(7));
  EXPECT_EQ(reception_->get_command_ns(), at(7));
  arrive(make_command(1, 0, 0.8), at(9));
  EXPECT_EQ(fsw().news_ns, at(7)) << "a duplicate is no news";
  EXPECT_EQ(take_due(0), std::vector<double>{0.8});
}

TEST_P(ReceptionTest, ACommandAfterTheCutoffIsForTheNextTick) {
  join();
  reception_->set_cutoff(at(10));
  arrive(make_command(1, 0, 0.6), at(10));
  arrive(make_command(2, 0, 0.7), at(11));
  EXPECT_EQ(take_due(0), std::vector<double>{0.6});
  EXPECT_EQ(take_due(1), std::vector<double>{0.7});
  EXPECT_EQ(commands_.get_late(), 1);
  EXPECT_EQ(connection_.sent.back().verdict.reason, static_cast<std::int32_t>(Reject::kLate));
}

TEST_P(ReceptionTest, ARefusedCommandIsAnsweredAndCounted) {
  join();
  arrive(make_command(1, 0, 5), at(1));
  ASSERT_EQ(connection_.sent.back().kind, MessageKind::kVerdict);
  EXPECT_EQ(connection_.sent.back().verdict.reason, static_cast<std::int32_t>(Reject::kOutOfRange));
  EXPECT_EQ(count(Reject::kOutOfRange), 1);
}

TEST_P(ReceptionTest, AnAnswerThatCannotBeIsRefused) {
  join();
  arrive(make_step_ack(1), at(1));  // the simulation is at tick 0
  EXPECT_EQ(count(Reject::kMalformed), 1);
  arrive(make_step_ack(0, 99), at(1));
  EXPECT_EQ(count(Reject::kUnknownParticipant), 1);
  EXPECT_FALSE(fsw().has_answered(0));
  arrive(make_step_ack(0), at(2));
  EXPECT_TRUE(fsw().has_answered(0));
}

TEST_P(ReceptionTest, AMessageOfALostParticipantBringsItBack) {
  join();
  (void)liveness_.lose(fsw());
  arrive(make_step_ack(0), at(5));
  EXPECT_TRUE(fsw().is_present());
  EXPECT_EQ(hil::get_name(connection_.sent.back().event.name), "participant.resumed");
}

TEST_P(ReceptionTest, AnotherSimulatorIsNoticedUnlessItsSessionIsOver) {
  hil::HelloMessage other;
  other.session = 4712;
  other.status = static_cast<std::int32_t>(hil::RunStatus::kDone);
  arrive(other, at(0));
  EXPECT_EQ(reception_->get_other().session, 0);
  other.status = static_cast<std::int32_t>(hil::RunStatus::kRunning);
  arrive(other, at(0));
  arrive(other, at(0));
  EXPECT_EQ(reception_->get_other().session, 4712);
  EXPECT_EQ(connection_.sent.size(), 1u) << "told once";
  EXPECT_FALSE(reception_->has_namesake());
}

TEST_P(ReceptionTest, AnotherSimulatorWithOurSessionNumberIsNoticedAndCountsMoreThanOthers) {
  hil::HelloMessage other;
  other.session = 4711;
  arrive(other, at(0));
  other.session = 4712;
  arrive(other, at(0));
  EXPECT_TRUE(reception_->has_namesake());
  EXPECT_EQ(reception_->get_other().session, 4711);
  EXPECT_EQ(connection_.list_kinds(), (std::vector<MessageKind>{MessageKind::kEvent, MessageKind::kEvent}));
}

TEST_P(ReceptionTest, EachOtherSimulatorIsToldOnceAndInventedOnesAreNotToldForEver) {
  hil::HelloMessage other;
  for (int round = 0; round < 3; ++round) {
    for (other.session = 1; other.session <= 2; ++other.session) arrive(other, at(0));
  }
  EXPECT_EQ(connection_.sent.size(), 2u);
  for (; other.session <= 1000; ++other.session) arrive(other, at(0));
  EXPECT_EQ(connection_.sent.size(), 8u);
}

INSTANTIATE_TEST_SUITE_P(Clocks, ReceptionTest, testing::Values(-1'000'000, -9, 0, 1'000'000));

}  // namespace
}  // namespace unlatch::test
