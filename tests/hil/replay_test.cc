// Replay: every tick's hash, the first difference by name.
#include <gtest/gtest.h>

#include "tests/hil/session_support.h"

namespace unlatch::test {
namespace {

using hil::Pace;

// Copies a recording, with each tick and the end passed through `edit`.
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

TEST_F(Replay, AChannelThatDoesNotExistIsADifferenceNotACrash) {
  rewrite(
      log_, edited_,
      [](hil::LogTick& tick) {
        if (tick.tick == 5) tick.changes.push_back({1000, hil::ChangeCause::kCommand, 0, 0, 1.0});
        return true;
      },
      leave);
  EXPECT_FALSE(replay_log(edited_).result.agrees());
}

// A fault is part of the run: the replay runs into the same one.
TEST(FastRun, AFaultIsReportedRecordedAndReplayed) {
  const hil::Scenario scenario = hil::load_scenario_text(
      kSessionScenario, "session.yaml",
      {"elements.engine.profile=1e308", "elements.engine.direction=[0, 1000, 0]", "elements.engine.point=[1, 0, 0]"});
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation, {});
  const std::string path = make_path("log");
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kFast, 0, 50));
  const std::atomic<bool> stop{false};
  std::atomic<std::int64_t> tick{0};
  hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, 50, stop, tick);
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
  hil::RunAnalysis analysis(scenario, *simulation, {0, 50});
  const std::string path = make_path("log");
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kFast, 0, 50));
  const std::atomic<bool> stop{false};
  std::atomic<std::int64_t> tick{0};
  hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, 50, stop, tick);
  recorder.close(end);
  EXPECT_EQ(end.status, hil::RunStatus::kDone);
  ASSERT_EQ(analysis.timeline.size(), 1u);
  EXPECT_NEAR(analysis.timeline[0].time, 0.0205, 1e-12);  // a time is a scheduled split: rounding alone
  ASSERT_EQ(analysis.tip_offs.size(), 1u);
  EXPECT_EQ(analysis.tip_offs[0].body, "pod");
  ASSERT_EQ(analysis.samples.size(), 2u);
  EXPECT_EQ(analysis.samples[1].reactions[0].mode, "free");
  const ReplayedLog replayed = replay_log(path);
  EXPECT_TRUE(replayed.result.agrees());
  EXPECT_EQ(replayed.result.compared, 51);
}

}  // namespace
}  // namespace unlatch::test
