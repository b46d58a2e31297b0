// The command queue: order, ticks, refusals.
#include "hil/session/participants/command_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/hil/session/fake_connection.h"

namespace unlatch::test::command_queue_test {
namespace {

using hil::Reject;

constexpr std::int64_t kHorizon = 1000, kPlaces = 32;

class CommandQueueTest : public ::testing::Test {
 protected:
  CommandQueueTest() {
    channels_[0].minimum = 0;
    channels_[0].maximum = 1;
    (void)participants_.admit(make_hello_ack(7, "beta"));
    (void)participants_.admit(make_hello_ack(8, "alpha"));
  }
  hil::CommandQueue make_queue(std::int64_t delay_ticks = 0, bool accept_late = false) {
    return {channels_,
            {.session = 4711,
             .delay_ticks = delay_ticks,
             .accept_late = accept_late,
             .horizon_ticks = kHorizon,
             .places = kPlaces},
            participants_,
            rejects_};
  }
  hil::CommandQueue::Outcome add(hil::CommandQueue& queue, const hil::CommandMessage& command,
                                 std::int64_t earliest_tick) {
    return queue.add(command, participants_.find(command.participant), earliest_tick);
  }
  std::vector<double> take(hil::CommandQueue& queue, std::int64_t tick) {
    std::vector<double> values;
    queue.take_due(tick, [&](const hil::CommandQueue::Pending& pending) { values.push_back(pending.command.value); });
    return values;
  }
  [[nodiscard]] std::int64_t count(Reject reason) const { return rejects_.by_reason[static_cast<std::size_t>(reason)]; }

  std::vector<Channel> channels_{1};
  hil::Participants participants_{{"beta", "alpha"}};
  hil::RejectCounts rejects_;
};

TEST_F(CommandQueueTest, OrderIsTickThenNameThenSequenceWhateverTheArrival) {
  hil::CommandQueue queue = make_queue();
  add(queue, make_command(2, 5, 0.4, 7), 3);
  add(queue, make_command(1, 5, 0.3, 7), 3);
  add(queue, make_command(9, 5, 0.2, 8), 3);
  add(queue, make_command(3, 4, 0.1, 7), 3);
  EXPECT_TRUE(take(queue, 3).empty());
  EXPECT_THAT(take(queue, 5), testing::ElementsAre(0.1, 0.2, 0.3, 0.4));
  EXPECT_TRUE(take(queue, 5).empty());
}

TEST_F(CommandQueueTest, ACommandActsAtItsTickPlusTheDelay) {
  hil::CommandQueue queue = make_queue(2);
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.5), 5).reason);
  EXPECT_TRUE(take(queue, 6).empty());
  EXPECT_THAT(take(queue, 7), testing::ElementsAre(0.5));
}

TEST_F(CommandQueueTest, ALateOneIsRefusedInLockstepAndActsNextInRealTime) {
  hil::CommandQueue lockstep = make_queue();
  EXPECT_EQ(add(lockstep, make_command(1, 4, 0.5), 5).reason, Reject::kPastTick);
  hil::CommandQueue realtime = make_queue(0, true);
  const auto outcome = add(realtime, make_command(2, 4, 0.5), 5);
  EXPECT_EQ(outcome.reason, Reject::kLate);
  EXPECT_EQ(outcome.applied_tick, 5);
  EXPECT_EQ(realtime.get_late(), 1);
  EXPECT_THAT(take(realtime, 5), testing::ElementsAre(0.5));
}

TEST_F(CommandQueueTest, RefusalsAreCountedByReason) {
  hil::CommandQueue queue = make_queue();
  hil::CommandMessage command = make_command(1, 5, 0.5);
  command.session = 1;
  EXPECT_EQ(add(queue, command, 5).reason, Reject::kWrongSession);
  EXPECT_EQ(add(queue, make_command(1, 5, 0.5, 99), 5).reason, Reject::kUnknownParticipant);
  EXPECT_EQ(add(queue, make_command(0, 5, 0.5), 5).reason, Reject::kMalformed);
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.5), 5).reason);
  EXPECT_EQ(add(queue, make_command(1, 5, 0.5), 5).reason, Reject::kDuplicate);
  EXPECT_EQ(add(queue, make_command(2, 5, 1.5), 5).reason, Reject::kOutOfRange);
  EXPECT_EQ(add(queue, make_command(3, 5, std::numeric_limits<double>::quiet_NaN()), 5).reason, Reject::kNotFinite);
  EXPECT_EQ(add(queue, make_command(4, 5, 0.5, 7, 1), 5).reason, Reject::kUnknownChannel);
  command = make_command(5, 5, 0.5);
  command.valid_until_tick = 4;
  EXPECT_EQ(add(queue, command, 5).reason, Reject::kExpired);
  for (const Reject reason :
       {Reject::kWrongSession, Reject::kUnknownParticipant, Reject::kMalformed, Reject::kDuplicate, Reject::kOutOfRange,
        Reject::kNotFinite, Reject::kUnknownChannel, Reject::kExpired}) {
    EXPECT_EQ(count(reason), 1) << hil::get_text(reason);
  }
}

TEST_F(CommandQueueTest, CommandsOfALostParticipantAreRemoved) {
  hil::CommandQueue queue = make_queue();
  add(queue, make_command(1, 5, 0.1, 7), 5);
  add(queue, make_command(1, 5, 0.2, 8), 5);
  queue.remove(*participants_.find(7));
  EXPECT_THAT(take(queue, 5), testing::ElementsAre(0.2));
}

TEST_F(CommandQueueTest, BeyondItsPlacesTheCommandsDueLastGiveWayWhateverTheArrival) {
  hil::CommandQueue queue = make_queue();
  for (std::int64_t i = 1; i <= kPlaces; ++i) EXPECT_FALSE(add(queue, make_command(i, 100 + i, 0.1), 5).reason);
  const auto near = add(queue, make_command(kPlaces + 1, 5, 0.9), 5);
  EXPECT_FALSE(near.reason);
  ASSERT_TRUE(near.displaced);
  EXPECT_EQ(near.displaced->sequence, kPlaces);
  EXPECT_EQ(add(queue, make_command(kPlaces + 2, 900, 0.1), 5).reason, Reject::kNoPlace);
  EXPECT_EQ(count(Reject::kNoPlace), 2);
  EXPECT_THAT(take(queue, 5), testing::ElementsAre(0.9));
}

TEST_F(CommandQueueTest, AParticipantHasItsOwnPlaces) {
  hil::CommandQueue queue = make_queue();
  for (std::int64_t i = 1; i <= 3 * kPlaces; ++i) add(queue, make_command(i, 100 + i, 0.1, 7), 5);
  EXPECT_EQ(count(Reject::kNoPlace), 2 * kPlaces);
  for (std::int64_t i = 1; i <= kPlaces; ++i) EXPECT_FALSE(add(queue, make_command(i, 5, 0.2, 8), 5).reason);
  EXPECT_EQ(take(queue, 5).size(), std::size_t{kPlaces});
}

TEST_F(CommandQueueTest, ACommandBeyondTheHorizonIsRefused) {
  hil::CommandQueue queue = make_queue();
  EXPECT_FALSE(add(queue, make_command(1, 5 + kHorizon, 0.5), 5).reason);
  EXPECT_EQ(add(queue, make_command(2, 6 + kHorizon, 0.5), 5).reason, Reject::kTooFar);
}

TEST_F(CommandQueueTest, ANumberFarAheadIsRefusedAndDoesNotHarmTheOthers) {
  hil::CommandQueue queue = make_queue();
  constexpr std::int64_t kFar = std::int64_t{1} << 40;
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.1), 5).reason);
  EXPECT_EQ(add(queue, make_command(kFar, 5, 0.5), 5).reason, Reject::kJump);
  for (std::int64_t i = 2; i <= 3000; ++i) {
    EXPECT_NE(add(queue, make_command(i, 5, 0.1), 5).reason, Reject::kDuplicate) << i;
    (void)take(queue, 5);
  }
}

// A repeated State is answered again, as the protocol demands.
TEST_F(CommandQueueTest, AnAnswerToARepeatedStateIsNoDuplicate) {
  hil::CommandQueue queue = make_queue();
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.5), 5).reason);
  queue.expect_repeats(5);
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.5), 5).reason);
  EXPECT_EQ(count(Reject::kDuplicate), 0);
  EXPECT_EQ(take(queue, 5).size(), 1u);
}

// A participant that stood still finds a State several times, and answers each: the last answers come when the next
// tick's State has been repeated too.
TEST_F(CommandQueueTest, TheLastAnswersToARepeatedStateMayComeBehindItsStep) {
  hil::CommandQueue queue = make_queue();
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.5), 5).reason);
  for (const std::int64_t tick : {5, 5, 6, 6}) queue.expect_repeats(tick);
  EXPECT_EQ(take(queue, 5).size(), 1u);
  EXPECT_FALSE(add(queue, make_command(1, 5, 0.5), 6).reason);
  EXPECT_EQ(count(Reject::kDuplicate), 0);
  queue.expect_repeats(7);
  EXPECT_EQ(add(queue, make_command(1, 5, 0.5), 7).reason, Reject::kDuplicate);
}

}  // namespace
}  // namespace unlatch::test::command_queue_test
