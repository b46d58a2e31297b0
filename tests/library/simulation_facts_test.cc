// Facts about the C library's simulations: the kernel's bits, stable arrays, no allocation, states, recordings,
// verdicts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <vector>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/run.h"
#include "tests/library/handles.h"
#include "tests/support/malloc_guard.h"

namespace unlatch::test::simulation_facts_test {
namespace {

constexpr int kWhole = 2000;  // ticks: past every event of the boosters' cyclogram

TEST(CLibrary, StepsToTheBitsOfTheKernel) {
  const auto direct = hil::build_simulation(hil::load_scenario(kReference));
  const Loaded sim(kReference);
  for (int tick = 0; tick < kWhole; ++tick) {
    ASSERT_EQ(direct->step().status, StepStatus::kOk);
    ASSERT_EQ(unlatch_step(sim.get()), UNLATCH_OK);
    if (tick % 100 == 0) {
      ASSERT_EQ(sim.get_hash(), static_cast<std::uint64_t>(direct->calc_hash())) << tick;
    }
  }
  EXPECT_EQ(sim.get_hash(), static_cast<std::uint64_t>(direct->calc_hash()));
}

// A sphere at 1 km over the equator: the air that a sensor reads is the standard's, a table over the altitude pushes
// it, and a channel scales the table.
const std::string kAir = R"(unlatch: 1
name: air
step: {dt: 10 ms, until: 1}
environment: {planet: wgs84, atmosphere: us1976}
start: {latitude: 0, longitude: 0, altitude: 1 km}
bodies: {ball: {mass: 2, inertia: [1, 1, 1]}}
channels: {gain: {initial: 1, range: [0, 4]}}
tables: {push: {axes: {height: {of: "altitude", at: [0, 1e5], ends: clamp}}, values: [6, 6], unit: N, scale_channel: gain}}
quantities:
  altitude: {altitude: ball}
  density: {density: ball}
elements: {push: {type: force, body: ball, frame: world, direction: [0, 1, 0], profile: {expression: "push"}}}
sensors: {rho: {type: quantity, quantity: density}}
)";

TEST(CLibrary, SeesLawsTablesAndTheAir) {
  constexpr double kGain = 2.5;
  double speeds[2];  // m/s, across, with the gains 1 and kGain
  for (int i = 0; i < 2; ++i) {
    unlatch_simulation* handle = nullptr;
    ASSERT_EQ(unlatch_load_text(kAir.data(), kAir.size(), "air.yaml", nullptr, &handle), UNLATCH_OK)
        << unlatch_get_error(0)->text;
    const Loaded sim(handle);
    EXPECT_STREQ(sim.describe(UNLATCH_SENSOR, 0).unit, "kg/m3");
    if (i == 1) {
      ASSERT_EQ(unlatch_set_channel(sim.get(), sim.find(UNLATCH_CHANNEL, "gain"), kGain), UNLATCH_OK);
    }
    ASSERT_EQ(unlatch_advance(sim.get(), 10, 0, nullptr), UNLATCH_OK);
    EXPECT_NEAR(sim.get_numbers(UNLATCH_SENSORS).at(0), 1.1117, 1e-4);  // kg/m³ by the standard's table at 1 km
    const unlatch_array velocities = sim.get_array(UNLATCH_VELOCITIES);
    speeds[i] = unlatch_get_number(&velocities, 0, 1);
  }
  EXPECT_NEAR(speeds[1] - speeds[0], (kGain - 1) * 6 / 2 * 0.1, 1e-8);  // the weight turns by 1e-9 of it
}

TEST(CLibrary, AdvancesAsSingleSteps) {
  const Loaded one(kReference), many(kReference);
  for (int tick = 0; tick < 900; ++tick) ASSERT_EQ(unlatch_step(one.get()), UNLATCH_OK);
  std::uint64_t done = 0;
  EXPECT_EQ(unlatch_advance(many.get(), 900, 0, &done), UNLATCH_OK);
  EXPECT_EQ(done, 900u);
  EXPECT_EQ(one.get_hash(), many.get_hash());
}

TEST(CLibrary, SteppingAndCommandsDoNotAllocate) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer has its own malloc";
  const Loaded sim(kScenario);
  std::vector<double> channels = sim.get_numbers(UNLATCH_CHANNELS);
  const AllocationCount count;
  for (int tick = 0; tick < kWhole; ++tick) {
    for (std::size_t i = 9; i < channels.size(); ++i) channels[i] = tick < 300 ? 0 : 1;  // cut-offs, ties, nozzles
    ASSERT_EQ(unlatch_set_channels(sim.get(), 0, channels.size(), channels.data()), UNLATCH_OK);
    ASSERT_EQ(unlatch_step(sim.get()), UNLATCH_OK);
  }
  ASSERT_EQ(unlatch_advance(sim.get(), 100, UNLATCH_STOP_AT_EVENTS, nullptr), UNLATCH_OK);
  EXPECT_EQ(count.get(), 0);
  EXPECT_GT(sim.count_events(), 10u);  // modes changed meanwhile
}

TEST(CLibrary, ArraysShowTheStateAtOneAddress) {
  const hil::Scenario scenario = hil::load_scenario(kReference);
  const auto direct = hil::build_simulation(scenario);
  const Loaded sim(kReference);
  const unlatch_array before = sim.get_array(UNLATCH_POSITIONS), nose = sim.get_array(UNLATCH_REACTIONS, 2);
  for (int tick = 0; tick < 700; ++tick) {
    ASSERT_EQ(unlatch_step(sim.get()), UNLATCH_OK);
    ASSERT_EQ(direct->step().status, StepStatus::kOk);
  }
  EXPECT_EQ(sim.get_array(UNLATCH_POSITIONS).data, before.data);
  ASSERT_EQ(before.rows, scenario.model.bodies.size());
  ASSERT_EQ(before.columns, 3u);
  const unlatch_array turn = sim.get_array(UNLATCH_ATTITUDES), w = sim.get_array(UNLATCH_ANGULAR_VELOCITIES),
                      v = sim.get_array(UNLATCH_VELOCITIES);
  for (std::size_t b = 0; b < before.rows; ++b) {
    const BodyState& body = direct->state().bodies[b];
    EXPECT_EQ(unlatch_get_number(&before, b, 1), body.p.y);
    EXPECT_EQ(unlatch_get_number(&turn, b, 0), body.q.w);
    EXPECT_EQ(unlatch_get_number(&turn, b, 3), body.q.z);
    EXPECT_EQ(unlatch_get_number(&v, b, 2), body.v.z);
    EXPECT_EQ(unlatch_get_number(&w, b, 0), body.w.x);
  }
  double largest = 0;
  for (std::size_t row = 0; row < 6; ++row) {
    EXPECT_EQ(unlatch_get_number(&nose, 0, row), direct->workspace().multipliers.get(2, row));
    largest = std::max(largest, std::abs(unlatch_get_number(&nose, 0, row)));
  }
  EXPECT_GT(largest, 0);
  const unlatch_array modes = sim.get_array(UNLATCH_JOINT_MODES);
  EXPECT_EQ(modes.type, UNLATCH_INT64);
  for (std::size_t j = 0; j < modes.rows; ++j) {
    const char* at = static_cast<const char*>(modes.data) + static_cast<std::ptrdiff_t>(j) * modes.row_stride;
    std::int64_t mode;
    std::memcpy(&mode, at, sizeof mode);
    EXPECT_EQ(mode, direct->state().joints[j].mode);
  }
}

TEST(CLibrary, ListsNamesAndUnits) {
  const Loaded sim(kScenario);
  EXPECT_EQ(sim.count(UNLATCH_BODY), 5u);
  EXPECT_EQ(sim.count(UNLATCH_JOINT), 4u);
  const unlatch_item rudder = sim.describe(UNLATCH_CHANNEL, sim.find(UNLATCH_CHANNEL, "rudder2"));
  EXPECT_STREQ(rudder.unit, "rad");
  EXPECT_DOUBLE_EQ(rudder.minimum, -0.35);
  EXPECT_DOUBLE_EQ(rudder.initial, -0.02);
  const unlatch_item gyro = sim.describe(UNLATCH_SENSOR, sim.find(UNLATCH_SENSOR, "gyro"));
  EXPECT_STREQ(gyro.unit, "rad/s");
  EXPECT_EQ(gyro.first, 4);
  EXPECT_EQ(gyro.width, 3);
  const unlatch_item release = sim.describe(UNLATCH_EVENT_KIND, sim.find(UNLATCH_EVENT_KIND, "release:booster3"));
  EXPECT_STREQ(release.name, "release");
  EXPECT_STREQ(release.text, "booster3");
  const unlatch_item distance = sim.describe(UNLATCH_REQUIREMENT, sim.find(UNLATCH_REQUIREMENT, "distance1"));
  EXPECT_STREQ(distance.unit, "m");
  EXPECT_DOUBLE_EQ(distance.minimum, 0.1);
  EXPECT_TRUE(std::isinf(distance.maximum));
  const unlatch_item nose = sim.describe(UNLATCH_JOINT, 0);
  EXPECT_EQ(nose.width, 4);
  const char* mode = nullptr;
  ASSERT_EQ(unlatch_get_mode_name(sim.get(), 0, 1, &mode), UNLATCH_OK);
  EXPECT_STREQ(mode, "hinge");
}

TEST(CLibrary, ListsWhatRequirementsCanBeAboutAndTheConstantsWithUnits) {
  const Loaded sim(kScenario);
  const unlatch_item force = sim.describe(UNLATCH_QUANTITY, sim.find(UNLATCH_QUANTITY, "reaction.nose1.x"));
  EXPECT_STREQ(force.unit, "N");
  EXPECT_STREQ(force.text, "reaction: {joint: nose1, row: x}");
  EXPECT_STREQ(sim.describe(UNLATCH_QUANTITY, sim.find(UNLATCH_QUANTITY, "rate.core")).unit, "rad/s");
  EXPECT_STREQ(sim.describe(UNLATCH_QUANTITY, sim.find(UNLATCH_QUANTITY, "time.release:booster4")).unit, "s");
  std::set<std::string> names;
  for (std::size_t i = 0; i < sim.count(UNLATCH_QUANTITY); ++i) names.insert(sim.describe(UNLATCH_QUANTITY, i).name);
  EXPECT_EQ(names.size(), sim.count(UNLATCH_QUANTITY));
  const unlatch_item radius = sim.describe(UNLATCH_CONSTANT, sim.find(UNLATCH_CONSTANT, "node_radius"));
  EXPECT_STREQ(radius.unit, "m");
  EXPECT_STREQ(radius.text, "constants.node_radius");
  EXPECT_EQ(radius.initial, 1.32);
}

TEST(CLibrary, ListsTheNumbersThatAScenarioWritesOutByTheirPaths) {
  const Loaded sim(kScenario);
  const unlatch_item mass = sim.describe(UNLATCH_NUMBER, sim.find(UNLATCH_NUMBER, "bodies.core.mass"));
  EXPECT_STREQ(mass.unit, "kg");
  EXPECT_EQ(mass.initial, 98500);
  std::set<std::string> paths;
  for (std::size_t i = 0; i < sim.count(UNLATCH_NUMBER); ++i) paths.insert(sim.describe(UNLATCH_NUMBER, i).name);
  EXPECT_EQ(paths.size(), sim.count(UNLATCH_NUMBER));
  EXPECT_GT(paths.size(), 100u);
  EXPECT_TRUE(paths.contains("bodies.booster4.mass"));                                         // of a template
  for (const std::string& path : paths) EXPECT_FALSE(path.starts_with("constants.")) << path;  // a separate kind
}

TEST(CLibrary, StopsAtEventsAndKeepsThem) {
  const Loaded sim(kReference);
  std::uint64_t done = 0;
  ASSERT_EQ(unlatch_advance(sim.get(), kWhole, UNLATCH_STOP_AT_EVENTS, &done), UNLATCH_EVENT);
  EXPECT_LT(done, static_cast<std::uint64_t>(kWhole));
  const unlatch_event* events = nullptr;
  std::size_t count = 0;
  std::uint64_t lost = 7;
  ASSERT_EQ(unlatch_get_events(sim.get(), &events, &count, &lost), UNLATCH_OK);
  ASSERT_GT(count, 0u);
  EXPECT_EQ(lost, 0u);
  EXPECT_EQ(events[0].tick, static_cast<std::int64_t>(done) - 1);
  EXPECT_NEAR(events[0].time, 1e-3 * static_cast<double>(done), 1e-3);  // inside that step

  unlatch_options options{};
  options.size = sizeof options;
  options.event_capacity = 2;
  const Loaded small(kReference, &options);
  ASSERT_EQ(unlatch_advance(small.get(), kWhole, 0, nullptr), UNLATCH_OK);
  ASSERT_EQ(unlatch_advance(sim.get(), kWhole - done, 0, nullptr), UNLATCH_OK);
  ASSERT_EQ(unlatch_get_events(small.get(), &events, &count, &lost), UNLATCH_OK);
  EXPECT_EQ(count, 2u);
  EXPECT_EQ(lost, sim.count_events() - 2);
}

TEST(CLibrary, ARestoredStateGoesOnWithTheSameBits) {
  const Loaded sim(kReference);
  ASSERT_EQ(unlatch_advance(sim.get(), 700, 0, nullptr), UNLATCH_OK);
  const std::vector<std::byte> saved = sim.save();
  ASSERT_EQ(unlatch_advance(sim.get(), 300, 0, nullptr), UNLATCH_OK);
  const std::uint64_t there = sim.get_hash();
  const Loaded other(kReference);
  ASSERT_EQ(unlatch_restore(other.get(), saved.data(), saved.size()), UNLATCH_OK);
  ASSERT_EQ(unlatch_advance(other.get(), 300, 0, nullptr), UNLATCH_OK);
  EXPECT_EQ(other.get_hash(), there);
  ASSERT_EQ(unlatch_reset(sim.get()), UNLATCH_OK);
  EXPECT_EQ(sim.count_events(), 0u);
  EXPECT_EQ(sim.get_hash(), Loaded(kReference).get_hash());
}

TEST(CLibrary, ADamagedOrForeignStateIsRefusedAndChangesNothing) {
  const Loaded sim(kReference);
  ASSERT_EQ(unlatch_advance(sim.get(), 10, 0, nullptr), UNLATCH_OK);
  const std::uint64_t before = sim.get_hash();
  std::vector<std::byte> saved = sim.save();
  for (const std::size_t at : {std::size_t{0}, std::size_t{9}, saved.size() / 2, saved.size() - 1}) {
    std::vector<std::byte> damaged = saved;
    damaged[at] ^= std::byte{4};
    EXPECT_EQ(unlatch_restore(sim.get(), damaged.data(), damaged.size()), UNLATCH_ERROR_STATE) << at;
  }
  EXPECT_EQ(unlatch_restore(sim.get(), saved.data(), saved.size() - 8), UNLATCH_ERROR_STATE);
  const Override heavier("bodies.core.mass=120 t");
  const Loaded other(kReference, heavier.get());
  EXPECT_EQ(unlatch_restore(other.get(), saved.data(), saved.size()), UNLATCH_ERROR_STATE);
  EXPECT_EQ(sim.get_hash(), before);
}

// Commands are recorded, also those before the beginning of a recording that does not begin at the start.
void record_and_replay(int before) {
  const Scratch scratch;
  const std::string path = scratch / "run.log";
  std::uint64_t hash = 0;
  {
    const Loaded sim(kScenario);
    ASSERT_EQ(unlatch_set_channel(sim.get(), 0, 0.75), UNLATCH_OK);
    ASSERT_EQ(unlatch_advance(sim.get(), static_cast<std::uint64_t>(before), 0, nullptr), UNLATCH_OK);
    ASSERT_EQ(unlatch_start_recording(sim.get(), path.c_str()), UNLATCH_OK);
    EXPECT_EQ(unlatch_reset(sim.get()), UNLATCH_ERROR_ORDER);
    for (int tick = 0; tick < 400; ++tick) {
      ASSERT_EQ(unlatch_set_channel(sim.get(), 5, 0.001 * (tick % 7)), UNLATCH_OK);
      ASSERT_EQ(unlatch_step(sim.get()), UNLATCH_OK);
    }
    ASSERT_EQ(unlatch_stop_recording(sim.get()), UNLATCH_OK);
    EXPECT_EQ(unlatch_stop_recording(sim.get()), UNLATCH_ERROR_ORDER);
    hash = sim.get_hash();
  }
  unlatch_simulation* replay = nullptr;
  ASSERT_EQ(unlatch_open_recording(path.c_str(), nullptr, &replay), UNLATCH_OK) << unlatch_get_error(0)->text;
  const Loaded owner(replay);
  EXPECT_EQ(unlatch_set_channel(replay, 0, 0.5), UNLATCH_ERROR_ORDER);
  EXPECT_EQ(unlatch_reset(replay), UNLATCH_ERROR_ORDER);
  std::uint64_t done = 0;
  EXPECT_EQ(unlatch_advance(replay, 100'000, 0, &done), UNLATCH_END) << unlatch_get_error(0)->text;
  EXPECT_EQ(done, 400u);
  EXPECT_EQ(owner.get_hash(), hash);
  EXPECT_DOUBLE_EQ(owner.get_numbers(UNLATCH_CHANNELS)[0], 0.75);
}

TEST(CLibrary, ARecordingFromTheStartReplays) { record_and_replay(0); }
TEST(CLibrary, ARecordingFromTheMiddleReplays) { record_and_replay(350); }

TEST(CLibrary, ARecordingThatCannotBeWrittenIsAnError) {
  const Loaded sim(kReference);
  EXPECT_EQ(unlatch_start_recording(sim.get(), "/nowhere/at/all.log"), UNLATCH_ERROR_FILE);
  EXPECT_EQ(unlatch_start_recording(sim.get(), ""), UNLATCH_ERROR_ARGUMENT);
  EXPECT_EQ(unlatch_stop_recording(sim.get()), UNLATCH_ERROR_ORDER);
}

TEST(CLibrary, JudgesAsARunDoes) {
  unlatch_options options{};
  options.size = sizeof options;
  options.flags = UNLATCH_JUDGE;
  const Loaded sim(kReference, &options);
  const hil::Scenario scenario = hil::load_scenario(kReference);
  const auto direct = hil::build_simulation(scenario);
  hil::RunAnalysis analysis(scenario, *direct);
  analysis.update(StepReport{});
  for (int tick = 0; tick < 1200; ++tick) {
    const StepReport report = direct->step();
    analysis.update(report);
    ASSERT_EQ(unlatch_step(sim.get()), UNLATCH_OK);
  }
  EXPECT_EQ(sim.get_hash(), static_cast<std::uint64_t>(direct->calc_hash()));
  const std::vector<hil::Verdict> wanted = analysis.judge();
  const unlatch_verdict* verdicts = nullptr;
  std::size_t count = 0;
  ASSERT_EQ(unlatch_judge(sim.get(), &verdicts, &count), UNLATCH_OK);
  ASSERT_EQ(count, wanted.size());
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(verdicts[i].value, wanted[i].value);
    EXPECT_EQ(verdicts[i].margin, wanted[i].margin);
    EXPECT_EQ(verdicts[i].met != 0, wanted[i].is_met());
  }
  const std::vector<double> clearances = sim.get_numbers(UNLATCH_CLEARANCES);
  ASSERT_EQ(clearances.size(), analysis.clearances().size());
  for (std::size_t i = 0; i < clearances.size(); ++i) EXPECT_EQ(clearances[i], analysis.clearances()[i].now);
}

// An impulse of 4 N s within a millisecond, by more points than a step of 5 ms is split at; a spring whose two points
// coincide.
constexpr const char* kUnresolved = R"(unlatch: 1
name: pulse
step: {dt: 5 ms, until: 2 s}
bodies:
  lid: {mass: 4 kg, inertia: [1, 1, 1]}
elements:
  pyro: {type: force, body: lid, frame: world, direction: [1, 0, 0], profile: {table: {times: [0, 1.0011, 1.0012, 1.0013, 1.0014, 1.0015, 1.0016, 1.0017, 1.0018, 1.0019, 1.002, 1.0021, 2], values: [0, 0, 1.6 kN, 3.2 kN, 4.8 kN, 6.4 kN, 8 kN, 6.4 kN, 4.8 kN, 3.2 kN, 1.6 kN, 0, 0]}}}
  spring: {type: spring, between: [ground, lid], stiffness: 1 N/m, free_length: 1}
)";

// Finding of a kind; null if there is none.
const unlatch_finding* find_finding(unlatch_simulation* sim, const std::string& name, bool of_run) {
  const unlatch_finding* findings = nullptr;
  std::size_t count = 0;
  EXPECT_EQ(unlatch_get_findings(sim, &findings, &count), UNLATCH_OK);
  for (std::size_t i = 0; i < count; ++i)
    if (findings[i].name == name && (findings[i].of_run != 0) == of_run) return &findings[i];
  return nullptr;
}

TEST(CLibrary, FindsWhatCheckFindsAndNoticesWhatTheStepDoesNotResolve) {
  for (const std::uint32_t flags : {0u, std::uint32_t{UNLATCH_NOTICE}, std::uint32_t{UNLATCH_JUDGE}}) {
    unlatch_options options{};
    options.size = sizeof options;
    options.flags = flags;
    unlatch_simulation* handle = nullptr;
    ASSERT_EQ(unlatch_load_text(kUnresolved, std::strlen(kUnresolved), "pulse", &options, &handle), UNLATCH_OK)
        << unlatch_get_error(0)->text;
    const Loaded sim(handle);
    const unlatch_finding* const of_scenario = find_finding(sim.get(), "direction", false);
    ASSERT_NE(of_scenario, nullptr);
    EXPECT_STREQ(of_scenario->subject, "element 'spring'");
    EXPECT_EQ(find_finding(sim.get(), "profile", true), nullptr);
    ASSERT_EQ(unlatch_advance(sim.get(), 400, 0, nullptr), UNLATCH_OK);
    const unlatch_finding* const noticed = find_finding(sim.get(), "profile", true);
    ASSERT_EQ(noticed != nullptr, flags != 0) << flags;
    if (noticed == nullptr) continue;
    EXPECT_STREQ(noticed->subject, "pyro");
    EXPECT_EQ(noticed->unresolved, 1);
    EXPECT_NEAR(noticed->time, 1, 0.01);
    ASSERT_EQ(unlatch_reset(sim.get()), UNLATCH_OK);
    EXPECT_EQ(find_finding(sim.get(), "profile", true), nullptr);
  }
}

TEST(CLibrary, NoticingChangesNoBit) {
  unlatch_options options{};
  options.size = sizeof options;
  options.flags = UNLATCH_NOTICE;
  const Loaded noticing(kReference, &options), plain(kReference);
  ASSERT_EQ(unlatch_advance(noticing.get(), 900, 0, nullptr), UNLATCH_OK);
  ASSERT_EQ(unlatch_advance(plain.get(), 900, 0, nullptr), UNLATCH_OK);
  EXPECT_EQ(noticing.get_hash(), plain.get_hash());
}

// Two balls that pass each other at 20 m a step, 0.3 m apart.
TEST(CLibrary, AVerdictSaysHowFarItsValueMayBeWrong) {
  const std::string text = R"(unlatch: 1
name: shake
step: {dt: 10 ms, until: 1 s}
bodies:
  c: {mass: 10, inertia: [1, 1, 1], shape: [{sphere: {radius: 0.1}}]}
  d: {mass: 10, inertia: [1, 1, 1], position: [-812, 0.5, 0], velocity: [2000, 0, 0], shape: [{sphere: {radius: 0.1}}]}
requirements:
  - {id: speed, velocity: {body: d, component: x}, at_most: 3000}
  - {id: distance, quantity: {clearance: {between: [c, d]}}, at_least: 0.01}
)";
  unlatch_options options{};
  options.size = sizeof options;
  options.flags = UNLATCH_JUDGE;
  unlatch_simulation* handle = nullptr;
  ASSERT_EQ(unlatch_load_text(text.data(), text.size(), "shake.yaml", &options, &handle), UNLATCH_OK)
      << unlatch_get_error(0)->text;
  const Loaded sim(handle);
  const unlatch_certainty* certainties = nullptr;
  std::size_t count = 1;
  ASSERT_EQ(unlatch_get_certainties(sim.get(), &certainties, &count), UNLATCH_OK);
  EXPECT_EQ(count, 0u);
  ASSERT_EQ(unlatch_advance(sim.get(), 100, 0, nullptr), UNLATCH_OK);
  const unlatch_verdict* verdicts = nullptr;
  ASSERT_EQ(unlatch_judge(sim.get(), &verdicts, &count), UNLATCH_OK);
  ASSERT_EQ(unlatch_get_certainties(sim.get(), &certainties, &count), UNLATCH_OK);
  ASSERT_EQ(count, 2u);
  EXPECT_EQ(certainties[0].uncertainty, 0);
  EXPECT_EQ(verdicts[1].evaluated, 0);  // unresolved
  EXPECT_GT(certainties[1].uncertainty, std::abs(verdicts[1].value - 0.3));
  EXPECT_EQ(certainties[1].at_ticks, 0);
}

TEST(CLibrary, WithoutTheFlagThereAreNoVerdicts) {
  const Loaded sim(kReference);
  const unlatch_verdict* verdicts = nullptr;
  std::size_t count = 0;
  EXPECT_EQ(unlatch_judge(sim.get(), &verdicts, &count), UNLATCH_ERROR_ORDER);
  unlatch_array array{};
  array.size = sizeof array;
  EXPECT_EQ(unlatch_get_array(sim.get(), UNLATCH_CLEARANCES, 0, &array), UNLATCH_ERROR_ORDER);
}

TEST(CLibrary, AFaultKeepsTheLastGoodState) {
  // A spring far beyond the stability of the explicit step: the numbers grow until they are not finite.
  const std::string text = R"(unlatch: 1
name: wild
step: {dt: 0.01, until: 1}
bodies:
  ball: {mass: 1 kg, inertia: [1, 1, 1], position: [2, 0, 0], velocity: [1, 2, 3]}
elements:
  spring: {type: spring, between: [ground, ball], stiffness: 1.0e+14, free_length: 1}
)";
  unlatch_simulation* handle = nullptr;
  ASSERT_EQ(unlatch_load_text(text.data(), text.size(), "wild.yaml", nullptr, &handle), UNLATCH_OK)
      << unlatch_get_error(0)->text;
  const Loaded sim(handle);
  std::uint64_t done = 0;
  ASSERT_EQ(unlatch_advance(handle, 1'000'000, 0, &done), UNLATCH_ERROR_FAULT);
  EXPECT_THAT(unlatch_get_error(0)->text, testing::HasSubstr("tick"));
  const std::uint64_t hash = sim.get_hash();
  EXPECT_EQ(unlatch_step(handle), UNLATCH_ERROR_FAULT);
  EXPECT_EQ(sim.get_hash(), hash);
  for (const double number : sim.get_numbers(UNLATCH_POSITIONS)) EXPECT_TRUE(std::isfinite(number));
}

}  // namespace
}  // namespace unlatch::test::simulation_facts_test
