// Lockstep: the result depends on the content of messages, never on the time or number of their arrivals.
#include <gtest/gtest.h>

#include "tests/hil/session/session_support.h"

namespace unlatch::test::lockstep_test {
namespace {

using hil::Pace;
using hil::RunStatus;
using Habits = FakeParticipant::Habits;

constexpr std::int64_t kTicks = 50;

std::int64_t get_reference_hash() {
  static const std::int64_t hash = run_session(Pace::kLockstep, {}).end.hash;
  return hash;
}

TEST(Lockstep, RunsToItsEnd) {
  const SessionResult result = run_session(Pace::kLockstep, {});
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_EQ(result.end.tick, kTicks);
  EXPECT_EQ(result.notices, std::vector<std::string>{"participant.joined"});
  EXPECT_EQ(result.end.timing.round_trip.count, kTicks);
  EXPECT_DOUBLE_EQ(result.channels[0], 0.5 + 0.005 * 40);
  EXPECT_DOUBLE_EQ(result.channels[1], -0.01 * 45);
}

TEST(Lockstep, CommandsMakeADifference) {
  const SessionResult fast = run_session(Pace::kFast, {});
  EXPECT_EQ(fast.end.status, RunStatus::kDone);
  EXPECT_NE(fast.end.hash, get_reference_hash());
}

TEST(Lockstep, ResultDoesNotDependOnTheOrderOfArrival) {
  Habits habits;
  habits.reversed = habits.ack_first = true;
  EXPECT_EQ(run_session(Pace::kLockstep, habits).end.hash, get_reference_hash());
}

TEST(Lockstep, DuplicatesChangeNothingAndAreCounted) {
  Habits habits;
  habits.twice = true;
  const SessionResult result = run_session(Pace::kLockstep, habits);
  EXPECT_EQ(result.end.hash, get_reference_hash());
  EXPECT_GT(result.end.timing.rejected[static_cast<std::size_t>(hil::Reject::kDuplicate)], 0);
}

TEST(Lockstep, ResendsUntilAcknowledged) {
  Habits habits;
  habits.deaf_at = 3;
  habits.deaf_times = 3;
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {"flight_software.timeout=10"});
  EXPECT_EQ(result.end.hash, get_reference_hash());
  EXPECT_GE(result.end.timing.resent, 3);
}

TEST(Lockstep, WaitsForTheCommandsThatAnAckAnnounces) {
  Habits habits;
  habits.commands_lost_at = 30;
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {"flight_software.timeout=10"});
  EXPECT_EQ(result.end.hash, get_reference_hash());
  EXPECT_GE(result.end.timing.resent, 1);
}

TEST(Lockstep, AParticipantIsLostOnceAndTheRunGoesOn) {
  const std::string log = make_path("log");
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, log);
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(result.end.tick, kTicks);
  EXPECT_EQ(result.notices, (std::vector<std::string>{"participant.joined", "policy.hold"}));
  EXPECT_DOUBLE_EQ(result.channels[0], 0.55);  // command of tick 10
  const ReplayedLog replayed = replay_log(log);
  EXPECT_TRUE(replayed.result.agrees()) << replayed.result.mismatch;
  EXPECT_EQ(replayed.result.compared, kTicks + 1);
}

TEST(Lockstep, AnnouncedCommandsThatNeverComeEndInThePolicy) {
  Habits habits;
  habits.announces_too_many_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {"flight_software.policy=abort"});
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_EQ(result.end.tick, 12);
}

TEST(Lockstep, AnOldAnswerRepeatedEndsInThePolicy) {
  Habits habits;
  habits.repeats_itself_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {"flight_software.policy=abort"});
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_EQ(result.end.tick, 12);
}

TEST(Lockstep, PolicyEvictKeepsTheValues) {
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {"flight_software.policy=evict"});
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(result.notices, (std::vector<std::string>{"participant.joined", "policy.evict"}));
  EXPECT_DOUBLE_EQ(result.channels[0], 0.55);  // command of tick 10
}

// Lists, from a recording, the ticks before whose step channels changed.
std::vector<std::int64_t> list_changes(const std::string& path, std::int32_t channel) {
  hil::RecordingReader recording{hil::LogFileReader(path)};
  std::vector<std::int64_t> ticks;
  hil::LogTick tick;
  while (recording.next(tick)) {
    for (const hil::LogChange& change : tick.changes) {
      if (change.channel == channel) ticks.push_back(tick.tick);
    }
  }
  return ticks;
}

TEST(Lockstep, ATransportDelayShiftsEveryCommand) {
  const std::string prompt = make_path("prompt"), delayed = make_path("delayed");
  run_session(Pace::kLockstep, {}, prompt);
  EXPECT_EQ(list_changes(prompt, 1), (std::vector<std::int64_t>{0, 15, 30, 45}));
  const SessionResult result = run_session(Pace::kLockstep, {}, delayed, {"flight_software.delay=1"});
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(list_changes(delayed, 1), (std::vector<std::int64_t>{1, 16, 31, 46}));
  EXPECT_EQ(result.end.timing.late_commands, 0);
}

TEST(Lockstep, APauseEndsAtItsLimit) {
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result =
      run_session(Pace::kLockstep, habits, "", {"flight_software.policy=pause", "flight_software.pause_limit=0.1"});
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_EQ(result.end.tick, 12);
  EXPECT_NE(result.end.message.find("'fsw' did not come back within the pause_limit"), std::string::npos);
}

TEST(Lockstep, PolicyZeroGoesToTheNearestValueOfTheRange) {
  const std::string log = make_path("log");
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, log, {"flight_software.policy=zero"});
  EXPECT_EQ(result.channels, (std::vector<double>{0.2, 0}));
  EXPECT_TRUE(replay_log(log).result.agrees());
}

TEST(Lockstep, PolicySafeGoesToTheSafeValues) {
  const std::string log = make_path("log");
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, log, {"flight_software.policy=safe"});
  EXPECT_EQ(result.channels, (std::vector<double>{0.3, 0.25}));
  const ReplayedLog replayed = replay_log(log);
  EXPECT_TRUE(replayed.result.agrees());
  EXPECT_EQ(replayed.result.compared, kTicks + 1);
}

TEST(Lockstep, PolicyAbortEndsTheRunAndSaysWhy) {
  const std::string log = make_path("log");
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result = run_session(Pace::kLockstep, habits, log, {"flight_software.policy=abort"});
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_EQ(result.end.tick, 12);
  EXPECT_NE(result.end.message.find("'fsw' did not answer"), std::string::npos) << result.end.message;
  const ReplayedLog replayed = replay_log(log);
  EXPECT_TRUE(replayed.complete);
  EXPECT_TRUE(replayed.result.agrees());
  EXPECT_EQ(replayed.result.compared, 13);
}

TEST(Lockstep, PolicyPauseWaitsAndThenGoesOnAsIfNothingHadBeen) {
  Habits habits;
  habits.dies_at = 12;
  habits.returns_after = std::chrono::milliseconds(200);
  const SessionResult result = run_session(Pace::kLockstep, habits, "", {"flight_software.policy=pause"});
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_EQ(result.end.hash, get_reference_hash());
  ASSERT_GE(result.notices.size(), 3u);
  EXPECT_EQ(result.notices[1], "policy.pause");
  EXPECT_EQ(result.notices[2], "participant.resumed");
}

}  // namespace
}  // namespace unlatch::test::lockstep_test
