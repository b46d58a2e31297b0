// Channels set by commands, policies and faults, and the record of it.
#include "hil/session/executive/channel_writer.h"

#include <gtest/gtest.h>

#include "tests/hil/session/session_support.h"

namespace unlatch::test::channel_writer_test {
namespace {

using hil::ChangeCause;
using hil::LogChange;

constexpr std::int32_t kFirst = 0, kSecond = 1;  // participants

// Channel 0 is the throttle (0.5 at the beginning, range 0.2 to 1, safe 0.3), 1 the trim (0.1, -1 to 1, 0.25).
class ChannelWriterTest : public ::testing::Test {
 protected:
  static LogChange command(std::int32_t channel, double value, std::int32_t participant = kFirst) {
    return {
        .channel = channel, .cause = ChangeCause::kCommand, .participant = participant, .sequence = 1, .value = value};
  }
  hil::FaultInjector& load_faults(const std::string& list) {
    return faults_.emplace(hil::load_faults_text("unlatch_faults: 1\nfaults:\n" + list, "faults.yaml", scenario_));
  }
  void begin_tick(std::int64_t tick, hil::ChannelWriter& channels) {
    hil::Participants nobody({});
    faults_->begin_tick(tick, 0, nobody, [](hil::Participant&) {});
    channels.update_faults();
  }
  [[nodiscard]] std::vector<double> get_values() const {
    return {simulation_->channels().begin(), simulation_->channels().end()};
  }
  // The changes of all ticks so far. Ends the recording.
  std::vector<LogChange> read_changes() {
    recorder_.tick(0, 0);
    hil::LogEnd end;
    recorder_.close(end);
    hil::RecordingReader recording{hil::LogFileReader(path_)};
    hil::LogTick tick;
    EXPECT_TRUE(recording.next(tick));
    return tick.changes;
  }

  const hil::Scenario scenario_ = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const std::unique_ptr<hil::Simulation> simulation_ = hil::build_simulation(scenario_);
  const std::string path_ = make_path("log");
  hil::Recorder recorder_{path_, hil::build_log_header(scenario_, *simulation_, hil::Pace::kFast, 4711, 1)};
  std::optional<hil::FaultInjector> faults_;
};

TEST_F(ChannelWriterTest, AChangeIsRecordedAndARepetitionIsNot) {
  hil::ChannelWriter channels(*simulation_, recorder_, nullptr);
  channels.set(command(0, 0.8));
  channels.set(command(0, 0.8));
  channels.set(command(1, 0.1));
  EXPECT_EQ(get_values(), (std::vector<double>{0.8, 0.1}));
  const std::vector<LogChange> changes = read_changes();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].channel, 0);
  EXPECT_EQ(changes[0].value, 0.8);
  EXPECT_EQ(changes[0].cause, ChangeCause::kCommand);
}

TEST_F(ChannelWriterTest, APolicyConcernsTheChannelsOfTheLostOneAndThoseOfNobody) {
  hil::ChannelWriter channels(*simulation_, recorder_, nullptr);
  channels.set(command(0, 0.8, kFirst));
  channels.apply_policy(hil::Policy::kSafe, kSecond);
  EXPECT_EQ(get_values(), (std::vector<double>{0.8, 0.25})) << "the trim has no commander";
  channels.apply_policy(hil::Policy::kSafe, kFirst);
  EXPECT_EQ(get_values(), (std::vector<double>{0.3, 0.25}));
  const std::vector<LogChange> changes = read_changes();
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(changes[1].cause, ChangeCause::kPolicy);
  EXPECT_EQ(changes[1].participant, kSecond);
  EXPECT_EQ(changes[2].participant, kFirst);
}

TEST_F(ChannelWriterTest, TheLatestCommandDecidesWhoseAChannelIs) {
  hil::ChannelWriter channels(*simulation_, recorder_, nullptr);
  channels.set(command(0, 0.8, kFirst));
  LogChange late = command(0, 0.8, kSecond);  // the same value, late
  late.cause = ChangeCause::kLateCommand;
  channels.set(late);
  channels.apply_policy(hil::Policy::kZero, kFirst);
  EXPECT_EQ(get_values()[0], 0.8);
  channels.apply_policy(hil::Policy::kZero, kSecond);
  EXPECT_EQ(get_values()[0], 0.2);
}

TEST_F(ChannelWriterTest, PoliciesWithoutAValueSetNothing) {
  hil::ChannelWriter channels(*simulation_, recorder_, nullptr);
  for (const hil::Policy policy : {hil::Policy::kHold, hil::Policy::kEvict}) channels.apply_policy(policy, kFirst);
  EXPECT_EQ(get_values(), (std::vector<double>{0.5, 0.1}));
  EXPECT_TRUE(read_changes().empty());
}

TEST_F(ChannelWriterTest, AFaultHoldsAChannelAndTheCommandActsAfterIt) {
  hil::ChannelWriter channels(*simulation_, recorder_, &load_faults("  - {jam: throttle, ticks: [1, 2]}\n"));
  begin_tick(1, channels);
  channels.set(command(0, 0.8));
  EXPECT_EQ(get_values()[0], 0.5);
  begin_tick(2, channels);
  EXPECT_EQ(get_values()[0], 0.5);
  begin_tick(3, channels);
  EXPECT_EQ(get_values()[0], 0.8);
  const std::vector<LogChange> changes = read_changes();
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].cause, ChangeCause::kFault);
  EXPECT_EQ(changes[0].participant, -1);
}

TEST_F(ChannelWriterTest, AChannelWithAFaultHasACommanderToo) {
  hil::ChannelWriter channels(*simulation_, recorder_, &load_faults("  - {dead: throttle, ticks: [1, 1]}\n"));
  begin_tick(1, channels);
  EXPECT_EQ(get_values()[0], 0);
  channels.set(command(0, 0.8, kFirst));
  channels.apply_policy(hil::Policy::kSafe, kSecond);
  begin_tick(2, channels);
  EXPECT_EQ(get_values()[0], 0.8) << "the second is none of its";
}

}  // namespace
}  // namespace unlatch::test::channel_writer_test
