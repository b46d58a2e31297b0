// Replay: the hash of every tick, the name of the first difference.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/hil/session/session_support.h"

namespace unlatch::test::replay_test {
namespace {

using hil::Pace;

// Copies a recording; `edit` may change each tick and the end.
template <class EditTick, class EditEnd>
void rewrite(const std::string& from, const std::string& to, EditTick&& edit_tick, EditEnd&& edit_end) {
  hil::LogFileReader reader(from);
  hil::LogFileWriter writer(to);
  hil::LogEvent event;
  while (reader.next(event) == hil::LogFileReader::Result::kEvent) {
    if (event.channel == hil::kTickChannel) {
      hil::LogTick tick;
      ASSERT_TRUE(decode(event.data, tick));
      if (!edit_tick(tick)) continue;
      encode(tick, event.data);
    } else if (event.channel == hil::kEndChannel) {
      hil::LogEnd end;
      ASSERT_TRUE(decode(event.data, end));
      edit_end(end);
      encode(end, event.data);
    }
    writer.append(event.timestamp_us, event.channel, event.data);
  }
}

class Replay : public ::testing::Test {
 protected:
  void SetUp() override {
    log_ = make_path("log");
    edited_ = make_path("edited");
    ASSERT_EQ(run_session(Pace::kLockstep, {}, log_).end.status, hil::RunStatus::kDone);
  }
  static bool keep(hil::LogTick&) { return true; }
  static void leave(hil::LogEnd&) {}
  std::string log_, edited_;
};

TEST_F(Replay, AgreesAtEveryTick) {
  const ReplayedLog replayed = replay_log(log_);
  EXPECT_TRUE(replayed.complete);
  EXPECT_TRUE(replayed.result.agrees()) << replayed.result.mismatch;
  EXPECT_EQ(replayed.result.compared, 51);
}

TEST_F(Replay, ShowsEveryState) {
  hil::RecordingReader recording{hil::LogFileReader(log_)};
  const hil::Scenario scenario = hil::load_recorded_scenario(recording.header);
  const auto simulation = hil::build_recorded_simulation(recording.header, scenario, log_);
  std::vector<std::int64_t> ticks, expected(51);
  std::iota(expected.begin(), expected.end(), 0);
  (void)hil::replay(recording, *simulation, nullptr,
                    [&](const StepReport&) { ticks.push_back(simulation->get_tick()); });
  EXPECT_EQ(ticks, expected);
}

TEST_F(Replay, NamesTheFirstTickThatDiffers) {
  rewrite(
      log_, edited_,
      [](hil::LogTick& tick) {
        if (tick.tick >= 33) tick.hash ^= 1;
        return true;
      },
      leave);
  const ReplayedLog replayed = replay_log(edited_);
  ASSERT_TRUE(replayed.result.difference);
  EXPECT_EQ(replayed.result.difference->tick, 33);
}

TEST_F(Replay, AnInputThatWasNotRecordedShowsAtTheNextTick) {
  rewrite(
      log_, edited_,
      [](hil::LogTick& tick) {
        if (tick.tick == 10) tick.changes.clear();
        return true;
      },
      leave);
  const ReplayedLog replayed = replay_log(edited_);
  ASSERT_TRUE(replayed.result.difference);
  EXPECT_EQ(replayed.result.difference->tick, 11);
}

TEST_F(Replay, ATickThatIsMissingIsDamage) {
  rewrite(
      log_, edited_, [](hil::LogTick& tick) { return tick.tick != 20; }, leave);
  const ReplayedLog replayed = replay_log(edited_);
  EXPECT_TRUE(replayed.damaged);
  EXPECT_NE(replayed.shortfall.find("tick 21 follows tick 19"), std::string::npos) << replayed.shortfall;
}

TEST_F(Replay, ARecordingThatLostItemsIsNotReplayable) {
  rewrite(log_, edited_, keep, [](hil::LogEnd& end) { end.unrecorded = 3; });
  EXPECT_THROW(replay_log(edited_), hil::LogError);
}

TEST_F(Replay, AnotherEndIsADifference) {
  rewrite(log_, edited_, keep, [](hil::LogEnd& end) { end.step_status = 1; });
  const ReplayedLog replayed = replay_log(edited_);
  EXPECT_FALSE(replayed.result.agrees());
  EXPECT_FALSE(replayed.result.mismatch.empty());
}

TEST_F(Replay, AChannelThatDoesNotExistIsRefused) {
  rewrite(
      log_, edited_,
      [](hil::LogTick& tick) {
        if (tick.tick == 5) tick.changes.push_back({1000, hil::ChangeCause::kCommand, 0, 0, 1.0});
        return true;
      },
      leave);
  EXPECT_THROW(replay_log(edited_), hil::LogError);
}

// Recorded inputs, tick by tick, and the messages of the executive.
struct Inputs {
  std::vector<std::pair<std::int64_t, hil::LogChange>> changes;
  std::vector<std::pair<std::int64_t, std::string>> notices;
};

Inputs read_inputs(const std::string& path) {
  Inputs inputs;
  hil::RecordingReader reader{hil::LogFileReader(path)};
  hil::LogTick tick;
  while (reader.next(tick)) {
    for (const hil::LogChange& change : tick.changes) inputs.changes.emplace_back(tick.tick, change);
  }
  for (const hil::EventMessage& notice : reader.notices) {
    inputs.notices.emplace_back(notice.tick, std::string(hil::get_name(notice.name)));
  }
  return inputs;
}

// Answers arrive at any time and commands name any tick, past ones too; then the flight software stops and the policy
// acts. The arrival times differ in each run; each replays to the hash of every tick.
class RealtimeReplay : public ::testing::TestWithParam<const char*> {};

TEST_P(RealtimeReplay, JitterStrayCommandsAndThePolicyAreAllInTheRecording) {
  const std::string policy = GetParam();
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  constexpr std::int64_t kSilentFrom = 60;
  FakeParticipant::Habits habits;
  habits.dies_at = kSilentFrom;
  habits.twice = true;
  habits.mischief = [random = std::mt19937(seed), sequence = std::int64_t{100'000}](
                        std::int64_t tick, hil::RingConnection& connection, std::int64_t session) mutable {
    if (random() % 8 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
    for (unsigned i = random() % 4; i > 0; --i) {
      hil::CommandMessage stray;
      stray.session = session;
      stray.sequence = ++sequence;
      stray.tick = std::max<std::int64_t>(0, tick + static_cast<std::int64_t>(random() % 21) - 10);
      stray.valid_until_tick = random() % 2 == 0 ? -1 : stray.tick + 5;
      stray.participant = FakeParticipant::kId;
      stray.channel = static_cast<std::int32_t>(random() % 2);
      stray.value = 0.2 + 0.8 * static_cast<double>(random() % 1000) / 1000;
      connection.deliver(stray);
    }
  };
  const std::string log = make_path(policy);
  const SessionResult result =
      run_session(Pace::kRealtime, habits, log,
                  {"flight_software.policy=" + policy, "flight_software.timeout=0.2", "step.until=1.2"});
  ASSERT_EQ(result.end.status, hil::RunStatus::kDone) << result.end.message;
  const ReplayedLog replayed = replay_log(log);
  EXPECT_TRUE(replayed.complete) << replayed.shortfall;
  EXPECT_TRUE(replayed.result.agrees()) << replayed.result.mismatch;
  EXPECT_EQ(replayed.result.compared, 1201);

  const Inputs inputs = read_inputs(log);
  ASSERT_EQ(inputs.notices.size(), 2u);
  EXPECT_EQ(inputs.notices[1].second, "policy." + policy);
  std::int64_t commands = 0;
  for (const auto& [tick, change] : inputs.changes) {
    if (change.cause == hil::ChangeCause::kCommand || change.cause == hil::ChangeCause::kLateCommand) {
      ++commands;
      continue;
    }
    EXPECT_EQ(change.cause, hil::ChangeCause::kPolicy);
    EXPECT_EQ(tick, inputs.notices[1].first) << "a policy acts at the tick that its notice names";
    EXPECT_EQ(change.value, result.channels[static_cast<std::size_t>(change.channel)]) << "nothing came after it";
    EXPECT_NE(policy, "hold") << "holding changes nothing";
  }
  EXPECT_GT(commands, 10);
}

INSTANTIATE_TEST_SUITE_P(EachPolicy, RealtimeReplay, ::testing::Values("hold", "zero", "safe"),
                         [](const auto& policy) { return std::string(policy.param); });

// A fault is part of the run: the replay reaches the same one.
TEST(FastRun, AFaultIsReportedRecordedAndReplayed) {
  const hil::Scenario scenario = hil::load_scenario_text(
      kSessionScenario, "session.yaml",
      {"elements.engine.profile=1e308", "elements.engine.direction=[0, 1000, 0]", "elements.engine.point=[1, 0, 0]"});
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  const std::string path = make_path("log");
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kFast, 0, 50));
  const std::atomic<bool> stop{false};
  hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, 50, stop, [] {});
  recorder.close(end);
  EXPECT_EQ(end.status, hil::RunStatus::kFaulted);
  EXPECT_EQ(end.tick, 0);
  EXPECT_NE(end.message.find("tick 0"), std::string::npos) << end.message;
  const ReplayedLog replayed = replay_log(path);
  EXPECT_TRUE(replayed.result.agrees()) << replayed.result.mismatch;
  EXPECT_EQ(replayed.result.compared, 1);
}

TEST(FastRun, RecordsAndReplays) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml", {"bodies.core.mass=120"});
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  const std::string path = make_path("log");
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kFast, 0, 50));
  const std::atomic<bool> stop{false};
  hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, 50, stop, [] {});
  recorder.close(end);
  EXPECT_EQ(end.status, hil::RunStatus::kDone);
  ASSERT_EQ(analysis.timeline.size(), 1u);
  EXPECT_NEAR(analysis.timeline[0].time, 0.0205, 1e-12);  // a time is a scheduled split: rounding alone
  ASSERT_EQ(analysis.tip_offs.size(), 1u);
  EXPECT_EQ(analysis.tip_offs[0].body, "pod");
  const ReplayedLog replayed = replay_log(path);
  EXPECT_TRUE(replayed.result.agrees());
  EXPECT_EQ(replayed.result.compared, 51);
}

}  // namespace
}  // namespace unlatch::test::replay_test
