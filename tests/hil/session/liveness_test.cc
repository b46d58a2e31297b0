// Answers, timeouts and policies; on any clock, including one that has just begun.
#include "hil/session/participants/liveness.h"

#include <gtest/gtest.h>

#include "tests/hil/session/fake_connection.h"

namespace unlatch::test::liveness_test {
namespace {

using hil::Policy;
using Standing = hil::Participant::Standing;

constexpr std::int64_t kTimeout_ns = 100;

// The parameter: the clock's reading at the beginning. Each case passes through it and beyond.
class LivenessTest : public ::testing::TestWithParam<std::int64_t> {
 protected:
  LivenessTest() { (void)participants_.admit(make_hello_ack()); }
  [[nodiscard]] std::int64_t at(std::int64_t ns) const { return GetParam() + ns; }
  hil::Participant& fsw() { return *participants_.find("fsw"); }

  hil::Participants participants_{{"fsw"}};
  hil::Liveness liveness_{participants_, Policy::kHold, kTimeout_ns};
};

TEST_P(LivenessTest, AnAnswerCompletesTheRound) {
  liveness_.begin_round(3, at(0));
  EXPECT_FALSE(liveness_.update(at(1)));
  EXPECT_FALSE(liveness_.take_round_trip_ns());
  liveness_.receive(make_step_ack(3), fsw(), at(40), at(41));
  EXPECT_TRUE(liveness_.update(at(42)));
  EXPECT_EQ(liveness_.take_round_trip_ns(), 40);
  EXPECT_TRUE(liveness_.update(at(43)));
  EXPECT_FALSE(liveness_.take_round_trip_ns()) << "once for each round";
  EXPECT_EQ(liveness_.find_overdue(at(10 * kTimeout_ns)), nullptr) << "it owes nothing";
}

TEST_P(LivenessTest, AnAnswerAfterTheNextStateIsARoundTripOfItsOwn) {
  liveness_.begin_round(3, at(0));
  liveness_.begin_round(4, at(100));
  liveness_.receive(make_step_ack(3), fsw(), at(130), at(131));
  EXPECT_EQ(liveness_.take_late_round_trip_ns(), 130);
  EXPECT_FALSE(liveness_.take_late_round_trip_ns());
  liveness_.receive(make_step_ack(4), fsw(), at(150), at(151));
  EXPECT_TRUE(liveness_.update(at(152)));
  EXPECT_EQ(liveness_.take_round_trip_ns(), 50);
  EXPECT_FALSE(liveness_.take_late_round_trip_ns());
  EXPECT_EQ(liveness_.get_late_answers(), 1);
  EXPECT_EQ(liveness_.get_unanswered(), 0);
}

TEST_P(LivenessTest, AnAnswerStandsForTheStatesBeforeAndThoseWithoutOneAreCounted) {
  for (int tick = 0; tick < 10; ++tick) liveness_.begin_round(tick, at(100 * tick));
  EXPECT_EQ(liveness_.get_unanswered(), 9) << "the latest may still be answered";
  liveness_.receive(make_step_ack(7), fsw(), at(1000), at(1000));
  int late = 0;
  while (liveness_.take_late_round_trip_ns()) ++late;
  EXPECT_EQ(late, 8);
  EXPECT_EQ(liveness_.get_late_answers(), 8);
  EXPECT_EQ(liveness_.get_unanswered(), 1);
  for (int tick = 10; tick < 1000; ++tick) liveness_.begin_round(tick, at(100 * tick));
  EXPECT_EQ(liveness_.get_unanswered(), 991) << "those whose place was given up are counted";
}

TEST_P(LivenessTest, AnAnswerIsOverdueAfterTheTimeout) {
  liveness_.begin_round(3, at(0));
  EXPECT_EQ(liveness_.find_overdue(at(kTimeout_ns)), nullptr);
  EXPECT_EQ(liveness_.find_overdue(at(kTimeout_ns + 1)), &fsw());
}

TEST_P(LivenessTest, AnAnswerToAnEarlierTickShowsThatItIsAlive) {
  liveness_.begin_round(3, at(0));
  liveness_.receive(make_step_ack(2), fsw(), at(60), at(60));
  EXPECT_FALSE(liveness_.update(at(60)));
  EXPECT_EQ(liveness_.find_overdue(at(kTimeout_ns + 60)), nullptr);
  EXPECT_EQ(liveness_.find_overdue(at(kTimeout_ns + 61)), &fsw());
}

TEST_P(LivenessTest, AnnouncedCommandsThatDoNotArriveAreNoAnswer) {
  liveness_.begin_round(3, at(0));
  hil::StepAckMessage ack = make_step_ack(3);
  ack.last_command = ack.command_count = 1;
  liveness_.receive(ack, fsw(), at(1), at(1));
  EXPECT_FALSE(liveness_.update(at(2)));
  (void)fsw().seen.insert(1);
  EXPECT_TRUE(liveness_.update(at(3)));
}

TEST_P(LivenessTest, APauseDoesNotCountAgainstAParticipant) {
  liveness_.begin_round(3, at(0));
  liveness_.restart(at(500));
  EXPECT_EQ(liveness_.find_overdue(at(500 + kTimeout_ns)), nullptr);
  EXPECT_EQ(liveness_.find_overdue(at(501 + kTimeout_ns)), &fsw());
}

TEST_P(LivenessTest, ALostOneResumesOnceAndOwesAnAnswer) {
  liveness_.begin_round(3, at(0));
  EXPECT_FALSE(liveness_.lose(fsw()));
  EXPECT_EQ(fsw().standing, Standing::kLost);
  EXPECT_TRUE(liveness_.update(at(1))) << "nobody is waited for";
  EXPECT_TRUE(liveness_.resume(fsw(), at(7)));
  EXPECT_FALSE(liveness_.resume(fsw(), at(8)));
  EXPECT_EQ(fsw().waiting_since_ns, at(7));
}

INSTANTIATE_TEST_SUITE_P(Clocks, LivenessTest, testing::Values(-1000, -60, -41, -40, -1, 0, 1, 1'000'000'000'000));

TEST(Liveness, OneThatLeavesIsOverdueAtOnceAndAGuestNever) {
  hil::Participants participants({"fsw"});
  (void)participants.admit(make_hello_ack(7, "fsw"));
  (void)participants.admit(make_hello_ack(8, "guest"));
  hil::Liveness liveness(participants, Policy::kEvict, kTimeout_ns);
  liveness.begin_round(0, 0);
  participants.find("guest")->leaving = true;
  EXPECT_EQ(liveness.find_overdue(0), nullptr);
  participants.find("fsw")->leaving = true;
  EXPECT_EQ(liveness.find_overdue(0), participants.find("fsw"));
  EXPECT_TRUE(liveness.lose(*participants.find("fsw")));
  EXPECT_EQ(participants.find("fsw")->standing, Standing::kEvicted);
}

TEST(Liveness, PoliciesSetChannelsWithinTheirRanges) {
  Channel channel;
  channel.minimum = 0.2;
  channel.maximum = 1;
  channel.safe = 0.3;
  EXPECT_EQ(hil::calc_policy_value(Policy::kZero, channel), 0.2);
  EXPECT_EQ(hil::calc_policy_value(Policy::kSafe, channel), 0.3);
  for (const Policy policy : {Policy::kHold, Policy::kPause, Policy::kAbort, Policy::kEvict}) {
    EXPECT_FALSE(hil::calc_policy_value(policy, channel)) << hil::get_text(policy);
  }
}

}  // namespace
}  // namespace unlatch::test::liveness_test
