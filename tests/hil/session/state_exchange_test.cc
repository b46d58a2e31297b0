// The exchange of a tick: silence, answers, missing commands; on any clock, also one that has just begun.
#include "hil/session/executive/state_exchange.h"

#include <gtest/gtest.h>

#include "hil/run/run.h"
#include "tests/hil/session/fake_connection.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::state_exchange_test {
namespace {

using hil::MessageKind;
using hil::RunStatus;

// The parameter: the clock's reading at the beginning.
class StateExchangeTest : public ::testing::TestWithParam<std::int64_t> {
 protected:
  StateExchangeTest() {
    (void)participants_.admit(make_hello_ack());
    exchange_.publish(RunStatus::kRunning, 99);
  }
  [[nodiscard]] std::int64_t at(std::int64_t ns) const { return GetParam() + ns; }
  hil::Participant& fsw() { return *participants_.find("fsw"); }
  void answer(std::int64_t last_command = 0, std::int32_t command_count = 0) {
    hil::StepAckMessage ack = make_step_ack(0);
    ack.last_command = last_command;
    ack.command_count = command_count;
    liveness_.receive(ack, fsw(), at(40), at(41));
  }

  const hil::Scenario scenario_ = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const std::unique_ptr<hil::Simulation> simulation_ = hil::build_simulation(scenario_);
  hil::Recorder recorder_{"", hil::LogHeader{}};
  FakeConnection connection_;
  ManualClock clock_{GetParam()};
  hil::Participants participants_{{"fsw"}};
  hil::Liveness liveness_{participants_, hil::Policy::kHold, 1'000'000'000};
  hil::RejectCounts rejects_;
  hil::CommandQueue commands_{simulation_->model().channels, {.session = 4711}, participants_, rejects_};
  hil::Publisher publisher_{*simulation_, recorder_, connection_, nullptr, 4711};
  hil::Histogram round_trip_;
  hil::StateExchange exchange_{*simulation_, clock_, participants_, liveness_, commands_, publisher_, round_trip_};
};

TEST_P(StateExchangeTest, ASilentParticipantIsQuietSinceTheState) {
  EXPECT_EQ(exchange_.get_quiet_since_ns(at(0)), at(0)) << "it has sent no command yet";
}

TEST_P(StateExchangeTest, ACommandBreaksTheSilence) {
  fsw().news_ns = at(30);
  EXPECT_EQ(exchange_.get_quiet_since_ns(at(0)), at(30));
  EXPECT_EQ(exchange_.get_quiet_since_ns(at(50)), at(50)) << "the State was sent after it";
  answer();
  EXPECT_EQ(exchange_.get_quiet_since_ns(at(0)), at(0)) << "it has answered";
}

TEST_P(StateExchangeTest, ANewStartHasSentNothing) {
  fsw().news_ns = at(30);
  (void)liveness_.lose(fsw());
  EXPECT_EQ(participants_.admit(make_hello_ack(8)), hil::Admission::kNewStart);
  EXPECT_EQ(exchange_.get_quiet_since_ns(at(0)), at(0));
}

TEST_P(StateExchangeTest, TheAnswerIsTimedFromTheState) {
  EXPECT_FALSE(exchange_.is_answered(at(10)));
  answer();
  EXPECT_TRUE(exchange_.is_answered(at(42)));
  EXPECT_TRUE(exchange_.is_answered(at(43)));
  EXPECT_EQ(round_trip_.get_count(), 1);
  EXPECT_EQ(round_trip_.get_max(), 40);
}

TEST_P(StateExchangeTest, ARepeatedStateAsksForTheCommandsThatAreMissing) {
  answer(5, 5);
  (void)fsw().seen.insert(2);
  connection_.sent.clear();
  exchange_.repeat(RunStatus::kRunning);
  EXPECT_EQ(connection_.list_kinds(),
            (std::vector<MessageKind>{MessageKind::kVerdict, MessageKind::kVerdict, MessageKind::kState}));
  EXPECT_EQ(connection_.sent[0].verdict.refers_to, 1);
  EXPECT_EQ(connection_.sent[0].verdict.count, 1);
  EXPECT_EQ(connection_.sent[1].verdict.refers_to, 3);
  EXPECT_EQ(connection_.sent[1].verdict.count, 3);
  EXPECT_EQ(publisher_.get_resent(), 1);
}

INSTANTIATE_TEST_SUITE_P(Clocks, StateExchangeTest, testing::Values(-3'600'000'000'000, -60, -1, 0, 1'000'000'000));

}  // namespace
}  // namespace unlatch::test::state_exchange_test
