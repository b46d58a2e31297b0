// Faults between the executive and its connection, and on channels; on any clock, including one that has just begun.
#include "hil/session/faults/faulty_connection.h"

#include <gtest/gtest.h>

#include "hil/session/faults/channel_faults.h"
#include "tests/hil/session/fake_connection.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::faulty_connection_test {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns

class FaultyConnectionTest : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void load(const std::string& list) {
    const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
    faults_.emplace(hil::load_faults_text("unlatch_faults: 1\nfaults:\n" + list, "faults.yaml", scenario));
    (void)participants_.admit(make_hello_ack());
    connection_.emplace(inner_, *faults_, participants_, clock_, [this](hil::Participant&) { ++resumed_; });
    faults_->begin_tick(0, clock_.now_ns, participants_, [](hil::Participant&) {});
  }
  void arrive(const hil::ParticipantMessage& message) { inner_.arrivals.push_back({message, clock_.now_ns}); }
  int receive_all() {
    int count = 0;
    while (connection_->receive(arrival_)) ++count;
    return count;
  }

  FakeConnection inner_;
  ManualClock clock_{GetParam()};
  hil::Participants participants_{{"fsw"}};
  std::optional<hil::FaultInjector> faults_;
  std::optional<hil::FaultyConnection> connection_;
  hil::Arrival arrival_;
  int resumed_ = 0;
};

TEST_P(FaultyConnectionTest, WithoutAFaultPassesEverythingWithItsTime) {
  load("  - {drop: {message: Health}}\n");
  arrive(make_command(1, 0, 0.5));
  const std::int64_t arrived_ns = clock_.now_ns;
  clock_.now_ns += 3;
  ASSERT_TRUE(connection_->receive(arrival_));
  EXPECT_EQ(arrival_.arrived_ns, arrived_ns);
  EXPECT_EQ(std::get<hil::CommandMessage>(arrival_.message).value, 0.5);
  EXPECT_FALSE(connection_->receive(arrival_));
  EXPECT_TRUE(connection_->send(hil::StateMessage{}));
  EXPECT_TRUE(connection_->send(hil::HealthMessage{})) << "dropped on purpose is not dropped";
  EXPECT_EQ(inner_.sent.size(), 1u);
}

TEST_P(FaultyConnectionTest, DropsAndDuplicates) {
  load("  - {drop: {message: StepAck}}\n  - {duplicate: {message: Command, copies: 2}}\n");
  arrive(make_step_ack(0));
  arrive(make_command(1, 0, 0.5));
  EXPECT_EQ(receive_all(), 3);
}

TEST_P(FaultyConnectionTest, DelaysByWallTime) {
  load("  - {delay: {message: Command, time: 3 ms}}\n  - {delay: {message: State, time: 2 ms}}\n");
  arrive(make_command(1, 0, 0.5));
  EXPECT_TRUE(connection_->send(hil::StateMessage{}));
  EXPECT_EQ(receive_all(), 0);
  EXPECT_TRUE(inner_.sent.empty());
  clock_.now_ns += 2 * kMs;
  EXPECT_EQ(receive_all(), 0);
  EXPECT_EQ(inner_.sent.size(), 1u);
  clock_.now_ns += kMs;
  ASSERT_TRUE(connection_->receive(arrival_));
  EXPECT_EQ(arrival_.arrived_ns, clock_.now_ns) << "it arrives when it is let through";
}

TEST_P(FaultyConnectionTest, AFreezeOfSomeWallTimeEndsAndTheParticipantIsResumed) {
  load("  - {freeze: {participant: fsw, time: 5 ms}, ticks: [0, end]}\n");
  arrive(make_command(1, 0, 0.5));
  EXPECT_EQ(receive_all(), 0);
  clock_.now_ns += 5 * kMs;
  EXPECT_EQ(receive_all(), 0);
  EXPECT_EQ(resumed_, 1);
  arrive(make_command(2, 0, 0.5));
  EXPECT_EQ(receive_all(), 1);
}

INSTANTIATE_TEST_SUITE_P(Clocks, FaultyConnectionTest,
                         testing::Values(-3'600'000'000'000, -4 * kMs, -2 * kMs, -1, 0, 1, 3'600'000'000'000));

TEST(ChannelFaults, KeepCommandsUntilTheFaultEnds) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  hil::FaultInjector injector(hil::load_faults_text("unlatch_faults: 1\nfaults:\n  - {dead: throttle, ticks: [1, 2]}\n",
                                                    "faults.yaml", scenario));
  hil::Participants participants({});
  const std::vector<double> begin{0.5, 0.1};
  hil::ChannelFaults channels(injector, begin);
  const auto begin_tick = [&](std::int64_t tick) {
    injector.begin_tick(tick, 0, participants, [](hil::Participant&) {});
  };
  begin_tick(0);
  EXPECT_TRUE(channels.command(0, 0.6, 0.5));
  EXPECT_EQ(channels.calc_value(0, 0.6), 0.6);
  begin_tick(1);
  EXPECT_EQ(channels.calc_value(0, 0.6), 0.0);
  EXPECT_FALSE(channels.command(0, 0.9, 0.0));
  EXPECT_TRUE(channels.command(1, 0.2, 0.1)) << "another channel";
  begin_tick(3);
  EXPECT_EQ(channels.calc_value(0, 0.0), 0.9);
}

}  // namespace
}  // namespace unlatch::test::faulty_connection_test
