// The cyclic executive: start, real time, refusals, heap use.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "hil/run/simulation/source_text.h"
#include "hil/session/realtime/clock.h"
#include "tests/hil/session/session_support.h"
#include "tests/support/malloc_guard.h"

namespace unlatch::test::executive_test {
namespace {

using hil::Pace;
using hil::Reject;
using hil::RunStatus;
using Habits = FakeParticipant::Habits;

TEST(Executive, SaysWhoIsMissingAtTheStart) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions options;
  options.last_tick = 10;
  options.flight_software = scenario.flight_software;
  options.start_timeout_ns = 150'000'000;
  hil::RingConnection connection(64, 64);
  hil::Recorder recorder("", hil::build_log_header(scenario, *simulation, Pace::kLockstep, 1, 10));
  hil::Executive executive(*simulation, connection, recorder, scenario.name, options);
  hil::LogEnd end = executive.run();
  recorder.close(end);
  EXPECT_EQ(end.status, RunStatus::kAborted);
  EXPECT_NE(end.message.find("no answer from the flight software 'fsw'"), std::string::npos) << end.message;
}

TEST(Executive, PassesOnWhyAParticipantRefuses) {
  Habits habits;
  habits.refuses = true;
  const SessionResult result = run_session(Pace::kLockstep, habits);
  EXPECT_EQ(result.end.status, RunStatus::kAborted);
  EXPECT_NE(result.end.message.find("the vehicle lacks channel warp"), std::string::npos) << result.end.message;
}

TEST(Executive, RefusesAndCountsWhatIsWrong) {
  Habits habits;
  habits.mischief = [](std::int64_t tick, hil::RingConnection& connection, std::int64_t session) {
    if (tick != 20) return;
    hil::CommandMessage good;
    good.session = session;
    good.sequence = 1000;
    good.tick = 20;
    good.valid_until_tick = -1;
    good.value = 0.5;
    good.participant = FakeParticipant::kId;
    auto send = [&connection, good, next = std::int64_t{1000}](auto&& spoil) mutable {
      hil::CommandMessage bad = good;
      bad.sequence = next++;
      spoil(bad);
      connection.deliver(bad);
    };
    send([](hil::CommandMessage& c) { c.session += 1; });
    send([](hil::CommandMessage& c) { c.participant = 99; });
    send([](hil::CommandMessage& c) { c.tick = 19; });
    send([](hil::CommandMessage& c) { c.valid_until_tick = 19; });
    send([](hil::CommandMessage& c) { c.value = std::numeric_limits<double>::quiet_NaN(); });
    send([](hil::CommandMessage& c) { c.value = std::numeric_limits<double>::infinity(); });
    send([](hil::CommandMessage& c) { c.value = 1.01; });
    send([](hil::CommandMessage& c) { c.channel = 2; });
    send([](hil::CommandMessage& c) { c.channel = -1; });
    send([](hil::CommandMessage& c) { c.tick = -5; });
  };
  const SessionResult result = run_session(Pace::kLockstep, habits);
  const auto count = [&](Reject reason) { return result.end.timing.rejected[static_cast<std::size_t>(reason)]; };
  EXPECT_EQ(count(Reject::kWrongSession), 1);
  EXPECT_EQ(count(Reject::kUnknownParticipant), 1);
  EXPECT_EQ(count(Reject::kPastTick), 1);
  EXPECT_EQ(count(Reject::kExpired), 1);
  EXPECT_EQ(count(Reject::kNotFinite), 2);
  EXPECT_EQ(count(Reject::kOutOfRange), 1);
  EXPECT_EQ(count(Reject::kUnknownChannel), 2);
  EXPECT_EQ(count(Reject::kMalformed), 1);
  EXPECT_EQ(result.end.hash, run_session(Pace::kLockstep, {}).end.hash);
}

TEST(Executive, CountsCommandsForTicksThatTheRunDoesNotReach) {
  Habits habits;
  habits.mischief = [](std::int64_t tick, hil::RingConnection& connection, std::int64_t session) {
    if (tick != 20) return;
    hil::CommandMessage early;
    early.session = session;
    early.valid_until_tick = -1;
    early.value = 0.5;
    early.participant = FakeParticipant::kId;
    for (const std::int64_t due : {30, 1000, 2000}) {
      early.sequence = 1000 + due;
      early.tick = due;
      connection.deliver(early);
    }
  };
  const SessionResult result = run_session(Pace::kLockstep, habits);
  EXPECT_EQ(result.end.timing.unused_commands, 2);
  EXPECT_EQ(run_session(Pace::kLockstep, {}).end.timing.unused_commands, 0);
}

TEST(Executive, ARunTooShortForItPrintsTheWholeScenarioAllTheSame) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto simulation = hil::build_simulation(scenario);
  hil::ExecutiveOptions options;
  options.pace = Pace::kFast;
  options.last_tick = 1;
  options.source = hil::build_source(std::string(5 * hil::kSourcePerPart, 'x'), {}, 0);
  hil::RingConnection connection(256, 64);
  hil::Recorder recorder("", hil::build_log_header(scenario, *simulation, Pace::kFast, 0, 1));
  hil::Executive executive(*simulation, connection, recorder, scenario.name, options);
  hil::LogEnd end = executive.run();
  recorder.close(end);
  hil::SourceText heard;
  std::int64_t next = 0;
  hil::Message message;
  while (connection.take(message)) {
    if (message.kind != hil::MessageKind::kSource) continue;
    EXPECT_EQ(message.source.sequence, next++);
    heard.add(message.source);
  }
  EXPECT_TRUE(heard.is_complete());
}

TEST(Realtime, KeepsItsPaceOverTheWholeRun) {
  const std::int64_t begin_ns = hil::get_monotonic_ns();
  const SessionResult result = run_session(Pace::kRealtime, {}, "", {"flight_software.timeout=10"});
  const std::int64_t took_ns = hil::get_monotonic_ns() - begin_ns;
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  EXPECT_GE(took_ns, 50'000'000);  // 50 ticks of 1 ms: it cannot be earlier; the delay depends on the machine
  EXPECT_EQ(result.end.timing.wakeup.count, 50);
}

TEST(Realtime, ALateCommandIsAppliedAtTheNextTickAndCounted) {
  const std::string log = make_path("log");
  Habits habits;
  habits.mischief = [](std::int64_t tick, hil::RingConnection& connection, std::int64_t session) {
    if (tick != 25) return;
    hil::CommandMessage late;
    late.session = session;
    late.sequence = 1000;
    late.tick = 5;
    late.valid_until_tick = -1;
    late.value = 0.77;
    late.participant = FakeParticipant::kId;
    connection.deliver(late);
    late.sequence = 1001;
    late.valid_until_tick = 6;  // too late for this one
    connection.deliver(late);
  };
  const SessionResult result = run_session(Pace::kRealtime, habits, log, {"flight_software.timeout=10"});
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  EXPECT_GE(result.end.timing.late_commands, 1);
  EXPECT_EQ(result.end.timing.rejected[static_cast<std::size_t>(Reject::kExpired)], 1);
  EXPECT_TRUE(replay_log(log).result.agrees());
  const std::vector<std::string> events = read_recording(log).events;
  // On a machine that is busy commands of the participant's own are late too, of both channels.
  const auto is_late = [](const std::string& event) { return event.starts_with("command.late fsw "); };
  EXPECT_EQ(std::ranges::count_if(events, is_late), result.end.timing.late_commands);
  EXPECT_EQ(std::ranges::count(events, "refused.expired fsw throttle"), 1);
}

// The gyro's x sticks at the value of tick 10, its z is biased; what was measured is in the replay.
TEST(Executive, ARecordingHasTheSensorValuesThatFlightSoftwareReceivedWhereTheyAreOthers) {
  const std::string log = make_path("log");
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  hil::FaultInjector faults(hil::load_faults_text("unlatch_faults: 1\nfaults:\n  - {stick: gyro.x, ticks: [10, 20]}\n"
                                                  "  - {bias: {sensor: gyro.z, by: 0.5}, ticks: [40, 60]}\n",
                                                  "faults.yaml", scenario),
                            3);
  const SessionResult result = run_session(Pace::kLockstep, {}, log,
                                           {"bodies.core.rate=[0.3, 0.2, 0.1]", "bodies.pod.rate=[0.3, 0.2, 0.1]",
                                            "bodies.pod.velocity=[0, 0.2, -0.4]", "flight_software.timeout=10"},
                                           true, nullptr, &faults);
  EXPECT_EQ(result.end.status, RunStatus::kDone) << result.end.message;
  const RecordedSession recorded = read_recording(log);
  ASSERT_EQ(recorded.received.size(), 51u);
  for (std::size_t tick = 0; tick <= 50; ++tick) {
    const std::vector<hil::LogReceived>& received = recorded.received[tick];
    if (tick > 10 && tick <= 20) {
      ASSERT_EQ(received.size(), 1u) << tick;
      EXPECT_EQ(received[0].value, 0);
      EXPECT_EQ(received[0].received, recorded.measured[10][0]);
    } else if (tick >= 40) {
      ASSERT_EQ(received.size(), 1u) << tick;
      EXPECT_EQ(received[0].value, 2);
      EXPECT_EQ(received[0].received, recorded.measured[tick][2] + 0.5);
    } else {
      EXPECT_TRUE(received.empty()) << tick;
    }
  }
  EXPECT_EQ(std::ranges::count(recorded.events, "fault.stick gyro.x"), 1);
}

TEST(Realtime, SilenceEndsInThePolicy) {
  const std::string log = make_path("log");
  Habits habits;
  habits.dies_at = 12;
  const SessionResult result =
      run_session(Pace::kRealtime, habits, log, {"flight_software.policy=safe", "step.until=0.4"});
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  ASSERT_EQ(result.notices.size(), 2u);
  EXPECT_EQ(result.notices[1], "policy.safe");
  EXPECT_EQ(result.channels, (std::vector<double>{0.3, 0.25}));
  const ReplayedLog replayed = replay_log(log);
  EXPECT_TRUE(replayed.result.agrees());
  EXPECT_EQ(replayed.result.compared, 401);
}

TEST(Realtime, ALostParticipantComesBack) {
  const std::string log = make_path("log");
  Habits habits;
  habits.dies_at = 12;
  habits.returns_after = std::chrono::milliseconds(200);
  const SessionResult result =
      run_session(Pace::kRealtime, habits, log, {"flight_software.policy=safe", "step.until=0.6"});
  EXPECT_EQ(result.end.status, RunStatus::kDone);
  ASSERT_GE(result.notices.size(), 3u);
  EXPECT_EQ(result.notices[1], "policy.safe");
  EXPECT_EQ(result.notices[2], "participant.resumed");
  // Its commands are checked again; by then they are outside the channels' ranges.
  EXPECT_GT(result.end.timing.rejected[static_cast<std::size_t>(Reject::kOutOfRange)], 0);
  EXPECT_TRUE(replay_log(log).result.agrees());
}

// A longer run allocates no more than a short one: allocations of run() are at its beginning and end only.
TEST(Executive, CycleDoesNotAllocate) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer has its own malloc";
  for (const Pace pace : {Pace::kLockstep, Pace::kRealtime}) {
    long counts[2];
    const char* const lengths[2] = {"step.until=0.01", "step.until=0.3"};
    for (int i = 0; i < 2; ++i) {
      const hil::Scenario scenario =
          hil::load_scenario_text(kSessionScenario, "session.yaml", {lengths[i], "flight_software.timeout=10"});
      const auto simulation = hil::build_simulation(scenario);
      hil::ExecutiveOptions options;
      options.pace = pace;
      options.session = 1;
      options.last_tick = static_cast<std::int64_t>(scenario.until / scenario.dt + 0.5);
      options.flight_software = scenario.flight_software;
      hil::RingConnection connection(256, 256);
      hil::Recorder recorder(make_path("log"),
                             hil::build_log_header(scenario, *simulation, pace, 1, options.last_tick));
      hil::Executive executive(*simulation, connection, recorder, scenario.name, options);
      hil::LogEnd end;
      {
        FakeParticipant participant(connection, {});
        const AllocationCount count;
        end = executive.run();
        counts[i] = count.get();
      }
      recorder.close(end);
      EXPECT_EQ(end.status, RunStatus::kDone);
    }
    EXPECT_EQ(counts[0], counts[1]) << "pace " << static_cast<int>(pace);
  }
}

TEST(Histogram, PercentilesAreWithinOneBucketOfTheTruth) {
  constexpr std::uint32_t kSeed = 20181011;
  SCOPED_TRACE(kSeed);
  constexpr double kBucket = 1.0 / 64;  // 64 buckets an octave
  std::mt19937 random(kSeed);
  std::lognormal_distribution<double> durations(9, 2);
  std::vector<std::int64_t> samples;
  hil::Histogram histogram;
  for (int i = 0; i < 20000; ++i) {
    samples.push_back(std::llround(durations(random)));
    histogram.record(samples.back());
  }
  std::sort(samples.begin(), samples.end());
  for (const double fraction : {0.5, 0.99, 0.999}) {
    const auto truth = samples[static_cast<std::size_t>(std::ceil(fraction * 20000)) - 1];
    const std::int64_t found = histogram.calc_percentile(fraction);
    EXPECT_GE(found, truth);
    EXPECT_LE(static_cast<double>(found), static_cast<double>(truth) * (1 + kBucket) + 1);
  }
  EXPECT_EQ(histogram.get_max(), samples.back());
  EXPECT_EQ(histogram.get_count(), 20000);
}

}  // namespace
}  // namespace unlatch::test::executive_test
