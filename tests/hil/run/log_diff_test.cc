// Comparison of recordings: the first tick, body and field that differ, the difference, and the inputs of the step.
#include "hil/run/log_diff.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "hil/run/checkpoint.h"
#include "tests/hil/session/session_support.h"

namespace unlatch::test::log_diff_test {
namespace {

using hil::Pace;

constexpr std::int64_t kTicks = 50;
using Program = std::function<double(std::int64_t tick)>;

// Records a run whose throttle follows `program`, as far as `ticks`.
void record(const std::string& path, const Program& program, const std::vector<std::string>& overrides = {},
            std::int64_t ticks = kTicks) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml", overrides);
  const auto simulation = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *simulation);
  hil::Recorder recorder(path, hil::build_log_header(scenario, *simulation, Pace::kFast, 1, kTicks));
  const std::atomic<bool> stop{false};
  hil::LogEnd end = hil::run_fast(*simulation, analysis, &recorder, ticks, stop, [&] {
    const double value = program(simulation->get_tick());
    if (value == simulation->channels()[0]) return;
    simulation->channels()[0] = value;
    recorder.change({0, hil::ChangeCause::kCommand, 7, simulation->get_tick() + 1, value});
  });
  recorder.close(end);
  ASSERT_EQ(end.status, hil::RunStatus::kDone);
}

double half(std::int64_t) { return 0.5; }

// Copies a recording; `edit` may change each event's data.
void rewrite(const std::string& from, const std::string& to, const std::function<void(hil::LogEvent&)>& edit) {
  hil::LogFileReader reader(from);
  hil::LogFileWriter writer(to);
  hil::LogEvent event;
  while (reader.next(event) == hil::LogFileReader::Result::kEvent) {
    edit(event);
    writer.append(event.timestamp_us, event.channel, event.data);
  }
}

struct Opened {
  explicit Opened(const std::string& path)
      : recording(hil::LogFileReader(path)),
        scenario(hil::load_recorded_scenario(recording.header)),
        simulation(hil::build_recorded_simulation(recording.header, scenario, path)) {}
  hil::RecordingReader recording;
  const hil::Scenario scenario;
  const std::unique_ptr<hil::Simulation> simulation;
};

class LogDiff : public ::testing::Test {
 protected:
  [[nodiscard]] hil::LogDiff compare() const {
    Opened a(a_), b(b_);
    return hil::diff({&a.recording, &b.recording}, {a.simulation.get(), b.simulation.get()});
  }
  [[nodiscard]] std::string get_refusal() const {
    try {
      (void)compare();
      return "";
    } catch (const hil::LogError& error) {
      return error.what();
    }
  }
  const std::string a_ = make_path("a"), b_ = make_path("b");
};

TEST_F(LogDiff, TwoRecordingsOfTheSameRunAgree) {
  record(a_, half);
  record(b_, half);
  const hil::LogDiff diff = compare();
  EXPECT_TRUE(diff.agrees());
  EXPECT_EQ(diff.first_tick, 0);
  EXPECT_EQ(diff.compared, kTicks + 1);
  EXPECT_EQ(diff.endings[0].unreproduced, -1);
}

// One command differs by a small amount that rounding does not hide: its effect is computed here independently.
TEST_F(LogDiff, NamesTheTickTheFieldAndTheDistance) {
  const double nudged = 0.7 + 1e-9;
  record(a_, [](std::int64_t tick) { return tick < 20 ? 0.5 : 0.7; });
  record(b_, [nudged](std::int64_t tick) { return tick < 20 ? 0.5 : nudged; });
  const hil::LogDiff diff = compare();
  EXPECT_FALSE(diff.agrees());
  ASSERT_TRUE(diff.input);
  EXPECT_EQ(diff.input->tick, 20);
  EXPECT_EQ(diff.input->channel, 0);
  EXPECT_EQ(diff.input->values, (hil::Two{0.7, nudged}));
  ASSERT_TRUE(diff.state);

  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto a = hil::build_simulation(scenario), b = hil::build_simulation(scenario);
  do {
    ASSERT_LT(a->get_tick(), kTicks);
    if (a->get_tick() == 20) {
      a->channels()[0] = 0.7;
      b->channels()[0] = nudged;
    }
    ASSERT_EQ(a->step().status, StepStatus::kOk);
    ASSERT_EQ(b->step().status, StepStatus::kOk);
  } while (a->calc_hash() == b->calc_hash());
  EXPECT_EQ(diff.state->tick, a->get_tick());
  EXPECT_EQ(diff.state->fields_tick, a->get_tick());
  EXPECT_EQ(diff.state->hashes, (std::array{a->calc_hash(), b->calc_hash()}));
  EXPECT_EQ(diff.state->channels[0], (hil::Two{0.7, nudged}));
  EXPECT_EQ(diff.state->channels[1], (hil::Two{0.1, 0.1}));
  ASSERT_FALSE(diff.state->fields.empty());
  bool found = false;
  for (const hil::FieldDifference& field : diff.state->fields) {
    if (field.of != "body 'core'" || field.field != "v.x") continue;
    found = true;
    const double of_a = a->state().bodies[0].v.x, of_b = b->state().bodies[0].v.x;
    EXPECT_EQ(field.get_a(), of_a);
    EXPECT_EQ(field.get_b(), of_b);
    std::uint64_t ulps = 0;
    for (double value = of_a; value != of_b; value = std::nextafter(value, of_b)) ++ulps;
    EXPECT_EQ(field.calc_ulps(), ulps);
  }
  EXPECT_TRUE(found) << "thrust along x moves the core along x; the first that differs is " << diff.state->fields[0].of
                     << " " << diff.state->fields[0].field;
}

TEST_F(LogDiff, TellsWhoSetWhatBeforeTheStep) {
  record(a_, half);
  record(b_, [](std::int64_t tick) { return tick < 30 ? 0.5 : 0.6; });
  const hil::LogDiff diff = compare();
  ASSERT_TRUE(diff.state);
  EXPECT_EQ(diff.state->tick, 31);
  EXPECT_TRUE(diff.state->changes[0].empty());
  ASSERT_EQ(diff.state->changes[1].size(), 1u);
  EXPECT_EQ(diff.state->changes[1][0].participant, 7);
  EXPECT_EQ(diff.state->changes[1][0].sequence, 31);
}

TEST_F(LogDiff, InputsThatDifferWithoutEffectAreADifference) {
  const std::vector<std::string> dead{"elements.engine.profile=0"};
  record(a_, half, dead);
  record(
      b_, [](std::int64_t tick) { return tick < 30 ? 0.5 : 0.6; }, dead);
  const hil::LogDiff diff = compare();
  EXPECT_FALSE(diff.agrees());
  EXPECT_FALSE(diff.state);
  ASSERT_TRUE(diff.input);
  EXPECT_EQ(diff.input->tick, 30);
  EXPECT_EQ(diff.compared, kTicks + 1);
}

// A recording as if another build had differed from tick 33 on: this program cannot compute its states, but they were
// recorded.
TEST_F(LogDiff, AStateThatThisProgramDoesNotReproduceIsReadFromTheRecording) {
  record(a_, half);
  rewrite(a_, b_, [](hil::LogEvent& event) {
    hil::LogTick tick;
    hil::StateMessage state;
    hil::LogEnd end;
    if (event.channel == hil::kTickChannel && decode(event.data, tick) && tick.tick >= 33) {
      tick.hash ^= 1;
      encode(tick, event.data);
    } else if (event.channel == hil::kEndChannel && decode(event.data, end)) {
      end.hash ^= 1;
      encode(end, event.data);
    } else if (event.channel == hil::get_channel(hil::MessageKind::kState) && decode(event.data, state) &&
               state.tick >= 33) {
      for (int i = 0; i < 3; ++i) state.bodies[1].z = std::nextafter(state.bodies[1].z, 1e9);
      encode(state, event.data);
    }
  });
  const hil::LogDiff diff = compare();
  EXPECT_EQ(diff.endings[0].unreproduced, -1);
  EXPECT_EQ(diff.endings[1].unreproduced, 33);
  ASSERT_TRUE(diff.state);
  EXPECT_EQ(diff.state->tick, 33);
  EXPECT_EQ(diff.state->fields_tick, 40);  // States are recorded every 10 ms
  ASSERT_EQ(diff.state->fields.size(), 1u);
  EXPECT_EQ(diff.state->fields[0].of, "body 'pod'");
  EXPECT_EQ(diff.state->fields[0].field, "p.z");
  EXPECT_EQ(diff.state->fields[0].calc_ulps(), 3u);
}

TEST_F(LogDiff, OneThatIsShorterIsSaidToBe) {
  record(a_, half);
  record(b_, half, {}, 30);
  hil::LogDiff diff = compare();
  EXPECT_FALSE(diff.agrees());
  EXPECT_FALSE(diff.state || diff.input);
  EXPECT_EQ(diff.compared, 31);
  EXPECT_EQ(diff.endings[0].tick, 50);
  EXPECT_EQ(diff.endings[1].tick, 30);
  EXPECT_EQ(diff.endings[1].status, hil::RunStatus::kDone);

  const std::string whole = read_bytes(a_);
  write_bytes(b_, whole.substr(0, whole.size() / 2));
  diff = compare();
  EXPECT_FALSE(diff.agrees());
  EXPECT_LT(diff.endings[1].tick, 50);
  EXPECT_EQ(diff.endings[1].status, std::nullopt);
  EXPECT_FALSE(diff.endings[1].message.empty());
  EXPECT_FALSE(diff.is_damaged());
}

TEST_F(LogDiff, DamageIsSaidToBeDamage) {
  record(a_, half);
  std::string bytes = read_bytes(a_);
  bytes[bytes.size() / 2] ^= 1;
  write_bytes(b_, bytes);
  const hil::LogDiff diff = compare();
  EXPECT_TRUE(diff.is_damaged());
  EXPECT_FALSE(diff.agrees());
}

TEST_F(LogDiff, ARunTakenUpAgainAgreesFromItsCheckpointOn) {
  record(a_, half);
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto first = hil::build_simulation(scenario), second = hil::build_simulation(scenario);
  while (first->get_tick() < 18) ASSERT_EQ(first->step().status, StepStatus::kOk);
  const std::string checkpoint = make_path("checkpoint");
  hil::write_checkpoint(checkpoint, scenario, *first, kTicks);
  hil::read_checkpoint(checkpoint, scenario, *second);
  hil::RunAnalysis analysis(scenario, *second);
  hil::Recorder recorder(b_, hil::build_log_header(scenario, *second, Pace::kFast, 1, kTicks));
  const std::atomic<bool> stop{false};
  hil::LogEnd end = hil::run_fast(*second, analysis, &recorder, kTicks, stop, [] {});
  recorder.close(end);
  const hil::LogDiff diff = compare();
  EXPECT_TRUE(diff.agrees());
  EXPECT_EQ(diff.first_tick, 18);
  EXPECT_EQ(diff.compared, kTicks - 18 + 1);
}

TEST_F(LogDiff, AnotherScenarioStepOrModelIsRefusedByName) {
  record(a_, half);
  record(b_, half, {"name=other"});
  EXPECT_NE(get_refusal().find("different scenarios, 'session' and 'other'"), std::string::npos);
  record(b_, half, {"step.dt=0.0005"});
  EXPECT_NE(get_refusal().find("different steps"), std::string::npos);
  record(b_, half, {"bodies.core.mass=101"});
  EXPECT_NE(get_refusal().find("different models"), std::string::npos);
}

TEST_F(LogDiff, ARecordingWithLossesIsRefused) {
  record(a_, half);
  rewrite(a_, b_, [](hil::LogEvent& event) {
    hil::LogEnd end;
    if (event.channel != hil::kEndChannel || !decode(event.data, end)) return;
    end.unrecorded = 5;
    encode(end, event.data);
  });
  EXPECT_NE(get_refusal().find("not replayable: 5"), std::string::npos) << get_refusal();
}

TEST(StateFields, DistanceCountsTheNumbersBetween) {
  const auto distance = [](double a, double b) {
    return hil::FieldDifference{"", "", true, std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)}
        .calc_ulps();
  };
  constexpr double kTiny = std::numeric_limits<double>::denorm_min(), kHuge = std::numeric_limits<double>::max();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(distance(1, std::nextafter(1, 2)), 1u);
  EXPECT_EQ(distance(-1, std::nextafter(-1, -2)), 1u);
  EXPECT_EQ(distance(1, 2), std::uint64_t{1} << 52);
  EXPECT_EQ(distance(-0.0, 0.0), 0u);
  EXPECT_EQ(distance(-kTiny, kTiny), 2u);
  EXPECT_EQ(distance(kHuge, kInfinity), 1u);
  EXPECT_EQ(distance(-kInfinity, kInfinity), 2 * std::uint64_t{0x7FF0000000000000});
  EXPECT_EQ(distance(std::nan(""), 1), std::nullopt);
  EXPECT_EQ((hil::FieldDifference{"", "mode", false, 1, 2}.calc_ulps()), std::nullopt);
}

// Fails if a word of the state was added to kernel/include/unlatch/state.h and not to
// hil/run/simulation/state_fields.cc.
TEST(StateFields, EveryWordOfTheStateHasANameOfItsOwn) {
  const hil::Scenario scenario = hil::load_scenario_text(kSessionScenario, "session.yaml");
  const auto a = hil::build_simulation(scenario), b = hil::build_simulation(scenario);
  const std::span<std::byte> block = b->state().get_bytes();
  std::set<std::string> names;
  for (std::size_t offset = 0; offset < block.size(); offset += 8) {
    block[offset] ^= std::byte{1};
    const auto differences = hil::compare_states(scenario.model, a->state(), b->state());
    block[offset] ^= std::byte{1};
    ASSERT_EQ(differences.size(), 1u);
    const std::string name = differences[0].of + " " + differences[0].field;
    EXPECT_TRUE(names.insert(name).second) << name << " twice";
    EXPECT_EQ(name.find(" word "), std::string::npos) << "word " << offset / 8;
  }
  EXPECT_TRUE(names.contains("body 'pod' q.w"));
  EXPECT_TRUE(names.contains("joint 'latch' mode"));
  EXPECT_TRUE(names.contains("element 'jet' duration"));
  EXPECT_TRUE(names.contains("event 'leave pod' phase"));
}

}  // namespace
}  // namespace unlatch::test::log_diff_test
