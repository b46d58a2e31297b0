// Bundles: runs side by side have the bits of separate runs.
#include "unlatch/bundle.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/golden/golden_models.h"
#include "tests/support/contact_models.h"
#include "tests/support/law_models.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/random_model.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/readings.h"

namespace unlatch::test::bundle_test {
namespace {

void delay(Condition& condition, double seconds) {
  if (condition.kind == Condition::Kind::kTime) condition.threshold += seconds;
  for (Condition& part : condition.parts) delay(part, seconds);
}

// Varies masses, loads, speeds and times of events; the structure stays.
Model disperse(const Model& model, int number) {
  Model out = model;
  const double grown = 1 + 0.01 * number;
  for (Body& body : out.bodies) {
    body.mass *= grown;
    body.inertia *= grown;
    if (!body.law) continue;
    for (MassLaw::Knot& knot : body.law->knots) {
      knot.mass *= grown;
      knot.inertia *= grown;
    }
  }
  for (Load& load : out.loads) load.direction *= 1 + 0.003 * number;
  for (Event& event : out.events) delay(event.when, 0.0037 * number);
  return out;
}

// A simulation that keeps the knots of its motion.
struct Logged {
  explicit Logged(const Model& model, const PlanOptions& options)
      : simulation(model, options), memory(MotionLog::get_bytes(simulation.plan)), log(simulation.plan, memory.get()) {
    (void)update_outputs(simulation.plan, {simulation.commands}, simulation.state, simulation.workspace);
  }
  Simulation simulation;
  Block memory;
  MotionLog log;
};

template <class Span>
std::string get_bytes(const Span& span) {
  return {reinterpret_cast<const char*>(span.data()), span.size() * sizeof(span[0])};
}

// Writes numbers; −0 is 0.
template <class Numbers>
std::string get_numbers(const Numbers& numbers) {
  std::string out;
  for (double number : numbers) {
    number += 0.0;
    out += get_bytes(std::span(&number, 1));
  }
  return out;
}

// All results of a step, by name.
using Parts = std::vector<std::pair<std::string, std::string>>;
Parts list_parts(const Logged& run, const StepReport& report) {
  Parts parts{{"state", get_bytes(run.simulation.state.get_bytes())},
              {"events", get_bytes(report.events)},
              {"report", std::to_string(static_cast<int>(report.status)) + " " + std::to_string(report.substeps) + " " +
                             std::to_string(report.postponed)}};
  const Workspace& workspace = run.simulation.workspace;
  std::vector<double> multipliers, accelerations;
  for (std::size_t i = 0; i < workspace.multipliers.size(); ++i) multipliers.push_back(workspace.multipliers[i]);
  for (std::size_t b = 0; b < workspace.accelerations.size(); ++b) {
    const Spatial a = workspace.accelerations[b];
    for (const Vec3& v : {a.lin, a.ang}) accelerations.insert(accelerations.end(), {v.x, v.y, v.z});
  }
  parts.emplace_back("multipliers", get_numbers(multipliers));
  parts.emplace_back("accelerations", get_numbers(accelerations));
  parts.emplace_back("sensors", get_numbers(workspace.sensors));
  std::vector<double> readings;
  for (int e = 0; e < static_cast<int>(run.simulation.state.elements.size()); ++e) {
    const ElementReading r = calc_element(run.simulation.plan, workspace, e);
    readings.insert(readings.end(), {r.force, r.length, r.rate, r.scale, r.stroke, r.wound, r.on_drum});
  }
  parts.emplace_back("readings of elements", get_numbers(readings));
  for (const MotionKnot& knot : run.log.get_knots()) {
    parts.emplace_back("knot's time", get_bytes(std::span(&knot.time, 1)) + (knot.begins ? "b" : "-"));
    parts.emplace_back("knot's state", get_bytes(knot.state.get_bytes()));
    parts.emplace_back("knot's sensors", get_numbers(knot.sensors));
    parts.emplace_back("knot's multipliers", get_numbers(knot.multipliers));
  }
  return parts;
}

// Returns the name of the first part that differs; empty if none does.
std::string find_difference(const Parts& a, const Parts& b) {
  if (a.size() != b.size()) return "number of knots";
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i]) return a[i].first;
  return "";
}

struct Fleet {
  Fleet(const std::vector<Model>& models, const PlanOptions& options) {
    std::vector<const Model*> all;
    std::vector<const Plan*> plans;
    for (const Model& model : models) {
      alone.push_back(std::make_unique<Logged>(model, options));
      together.push_back(std::make_unique<Logged>(model, options));
      all.push_back(&model);
      plans.push_back(&together.back()->simulation.plan);
      Simulation& s = together.back()->simulation;
      runs.push_back({&s.plan, {s.commands}, &s.state, &s.workspace, &together.back()->log});
    }
    bundle = Bundle::build(all, plans);
  }

  // Steps both; returns the first difference with its run, or nothing. Runs whose step failed have ended.
  std::string advance() {
    bundle->step(runs);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      if (!runs[k].goes_on) continue;
      Logged& one = *alone[k];
      const StepReport report = step(one.simulation.plan, {one.simulation.commands}, one.simulation.state,
                                     one.simulation.workspace, &one.log);
      split += report.substeps > 1;
      if (report.status != StepStatus::kOk) runs[k].goes_on = false;
      if (report.status != runs[k].report.status) return "run " + std::to_string(k) + ": status";
      if (report.status != StepStatus::kOk) continue;
      const std::string difference = find_difference(list_parts(one, report), list_parts(*together[k], runs[k].report));
      if (!difference.empty()) return "run " + std::to_string(k) + ": " + difference;
    }
    return "";
  }

  std::vector<std::unique_ptr<Logged>> alone, together;
  std::vector<BundleRun> runs;
  std::optional<Bundle> bundle;
  int split = 0;  // steps with events
};

std::vector<Model> build_fleet(const Model& model, int runs) {
  std::vector<Model> models;
  for (int k = 0; k < runs; ++k) models.push_back(disperse(model, k));
  return models;
}

// With the instruction sets other than the processor's widest only the first part of each flight.
void expect_golden_models_alike(int part) {
  int bundles = 0;
  for (const GoldenModel& golden : build_golden_models())
    for (const InstructionSet set : {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::kAuto}) {
      PlanOptions options;
      options.dt = golden.dt;
      options.instruction_set = set;
      if (!is_supported(set)) continue;
      Fleet fleet(build_fleet(golden.model, 5), options);
      if (!fleet.bundle) continue;
      ++bundles;
      const int ticks = set == InstructionSet::kAuto ? golden.ticks : golden.ticks / part;
      for (int tick = 0; tick < ticks; ++tick)
        ASSERT_EQ(fleet.advance(), "") << golden.model.name << " tick " << tick << " " << get_name(set);
    }
  EXPECT_GT(bundles, 10);
}

TEST(Bundle, RunsOfTheGoldenModelsHaveTheBitsOfEachAlone) { expect_golden_models_alike(5); }
TEST(LongBundle, RunsOfTheGoldenModelsHaveTheBitsOfEachAloneToTheirEndsInEveryWidth) { expect_golden_models_alike(1); }

TEST(Bundle, BoostersThatSeparateAtDifferentTicksHaveTheBitsOfEachAlone) {
  Fleet fleet(build_fleet(build_soyuz(load_reference("soyuz_nominal")), 8), {});
  ASSERT_TRUE(fleet.bundle);
  for (int tick = 0; tick < 1200; ++tick) ASSERT_EQ(fleet.advance(), "") << "tick " << tick;
  EXPECT_GE(fleet.split, 32) << "four hinges and four sliders of each, at their own ticks";
}

TEST(Bundle, RandomSystemsWhoseJointsChangeAtDifferentTimesHaveTheBitsOfEachAlone) {
  constexpr std::uint64_t kFirstSeed = 88100;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 60; ++seed) {
    std::mt19937_64 random(seed);
    Model model = build_random_model(seed);
    for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
      Event event;
      event.name = "change" + std::to_string(j);
      event.when = when_time(0.001 * static_cast<double>(random() % 40) + 0.0005);
      event.then = {act_set_mode(j, static_cast<int>(random() % model.joints[at(j)].modes.size()))};
      model.events.push_back(event);
    }
    Fleet fleet(build_fleet(model, 2 + static_cast<int>(seed % 7)), {});
    if (!fleet.bundle) continue;
    for (int tick = 0; tick < 60; ++tick) ASSERT_EQ(fleet.advance(), "") << "seed " << seed << " tick " << tick;
  }
}

TEST(Bundle, RunsWithClosedContactsHaveTheBitsOfEachAlone) {
  for (Model model : {build_dropped_ball(0.02), build_block_on_feet(), build_sixteen_pairs()}) {
    model.contact_substeps = 4;
    Fleet fleet(build_fleet(model, 4), {});
    ASSERT_TRUE(fleet.bundle);
    for (int tick = 0; tick < 300; ++tick) ASSERT_EQ(fleet.advance(), "") << model.name << " tick " << tick;
  }
}

// Rockets that empty tanks of several stages of emptiness, each at its own instants: their steps are split there.
TEST(Bundle, TanksThatEmptyAtTheirOwnInstantsHaveTheBitsOfEachAlone) {
  constexpr double kThrust = 500, kExhaust = 2500, kFull = 20;  // N, m/s, kg
  Model model;
  model.name = "tanks";
  for (const char* name : {"first", "second"}) {
    Body& tank = model.bodies.emplace_back(box(name, kFull, 2, 3, 4));
    MassLaw law;
    law.of = MassLaw::Of::kBurnt;
    for (const double burnt : {0.0, 0.0153, 0.0171, 0.0402})
      law.knots.push_back({burnt, kFull - burnt, {2 * burnt * burnt, 0, 0}, (1 - burnt) * tank.inertia});
    tank.law = law;
    Load& load = model.loads.emplace_back();
    load.name = std::string("thrust of ") + name;
    load.body = static_cast<int>(model.bodies.size()) - 1;
    load.point = {0, 0.01, 0};
    load.profile.value = kThrust * (load.body + 1);
    load.consumption = 1 / kExhaust;
  }
  Fleet fleet(build_fleet(model, 6), {});
  ASSERT_TRUE(fleet.bundle);
  constexpr int kTicks = 250;
  for (int tick = 0; tick < kTicks; ++tick) ASSERT_EQ(fleet.advance(), "") << "tick " << tick;
  EXPECT_GE(fleet.split, 6 * 2) << "knots of what is burnt";
  // What the first run has burnt: the thrust's impulse by the speed of its exhaust.
  for (const int tank : {0, 1})
    EXPECT_NEAR(fleet.together[0]->simulation.state.auxiliary[at(tank)],
                kThrust * (tank + 1) * 0.001 * kTicks / kExhaust, 1e-12);
}

// A law that only outputs read splits no step; the log of its run marks where it passes a knot, in a bundle too. Masses
// over time, the rows of the wind and a branch do so beside it.
TEST(Bundle, LogsOfRunsWithLawsHaveTheBitsOfEachAlone) {
  using namespace laws;
  using laws::Kind;
  std::vector<Model> models;
  for (int i = 0; i < 4; ++i) {
    Model model = build_pushed({constant(2)});
    model.name = "watched";
    model.quantities.push_back(along_x(Quantity::Kind::kAltitude, "altitude"));
    model.laws.push_back(law_of({quantity(1), step_of(Kind::kTable, 0), quantity(1), constant(10012.3), constant(1),
                                 constant(2), step_of(Kind::kIfLess), step_of(Kind::kMultiply)},
                                "watched"));
    model.tables.push_back(
        table_of({{9e3, 10003.1, 10020.4, 11e3}}, [](const auto& at) { return 1e-8 * at[0] * at[0]; }));
    Quantity& output = model.quantities.emplace_back();
    output.name = "watched law";
    output.kind = Quantity::Kind::kLaw;
    output.subject = 1;
    model.environment = {.planet = Planet{}, .atmosphere = Atmosphere{}, .wind = Wind{}, .launch = {}};
    model.environment.wind = {.altitudes = {9e3, 10.02e3}, .velocities = {{0, 0, 0}, {20, 0, 0}}};
    Aerodynamics air{.name = "air", .body = 0, .area = 0.01, .terms = {}};
    air.terms = {{AeroTerm::Of::kDrag, kNone, 0.4, kNone}};
    model.aerodynamics = {air};
    MassLaw law;
    law.knots = {{0, 2, {0, 0, 0}, model.bodies[0].inertia},
                 {0.0405 + 0.01 * i, 1.9, {0, 0, 0}, model.bodies[0].inertia}};
    model.bodies[0].law = law;
    Start start;
    start.body = 0;
    start.altitude = 10e3;
    start.velocity = {100, 0, -200};
    start.origin = Start::Origin::kStart;
    models.push_back(place_start(model, start));
    models.back().bodies[0].v_WB *= 1 + 0.0001 * i;
  }
  Fleet fleet(models, {});
  ASSERT_TRUE(fleet.bundle);
  int corners = 0;
  for (int tick = 0; tick < 200; ++tick) {
    ASSERT_EQ(fleet.advance(), "") << "tick " << tick;
    for (std::size_t k = 0; k < models.size(); ++k) {
      const auto alone = fleet.alone[k]->log.get_knots(), together = fleet.together[k]->log.get_knots();
      ASSERT_EQ(alone.size(), together.size());
      for (std::size_t i = 0; i < alone.size(); ++i) {
        ASSERT_EQ(alone[i].corner, together[i].corner) << "run " << k << ", tick " << tick;
        ASSERT_EQ(alone[i].reading_corner, together[i].reading_corner) << "run " << k << ", tick " << tick;
        corners += alone[i].corner || alone[i].reading_corner;
      }
    }
  }
  EXPECT_GT(corners, 4 * 5) << "knots of the law, its branch, of the mass, and of the wind";
}

// Conditions on commands: those of one run change while the others' stay.
TEST(Bundle, RunsWhoseCommandsMakeEventsHaveTheBitsOfEachAlone) {
  constexpr int kRuns = 5;
  std::vector<Model> models;
  for (int k = 0; k < kRuns; ++k) {
    Model model;
    model.name = "commanded";
    model.bodies = {box("a", 3 + 0.1 * k, 1, 2, 3), box("b", 2, 1, 1, 1)};
    model.bodies[0].w_WB_B = {0.1, 0.2, 0.3 * k};
    model.bodies[1].p_WB = {1, 0, 0};
    PointSpring& spring = model.point_springs.emplace_back();
    spring.name = "spring";
    spring.base = 0;
    spring.follower = 1;
    spring.stiffness = 50;
    spring.free_length = 0.9;
    Channel& channel = model.channels.emplace_back();
    channel.name = "switch";
    Event& event = model.events.emplace_back();
    event.name = "off";
    event.when = when(Condition::Kind::kCommand, 0, 0, 0.5);
    event.repeat = true;
    event.then.resize(1);
    event.then[0].kind = Action::Kind::kSwitch;
    models.push_back(model);
  }
  Fleet fleet(models, {});
  ASSERT_TRUE(fleet.bundle);
  int fired = 0;
  for (int tick = 0; tick < 60; ++tick) {
    for (int k = 0; k < kRuns; ++k)
      for (Logged* run : {fleet.alone[at(k)].get(), fleet.together[at(k)].get()})
        run->simulation.commands[0] = tick > 10 + 7 * k && tick < 40 ? 1 : 0;
    ASSERT_EQ(fleet.advance(), "") << "tick " << tick;
    for (const BundleRun& run : fleet.runs) fired += static_cast<int>(run.report.events.size());
  }
  EXPECT_EQ(fired, kRuns);
}

// A run that fails or ends does not disturb the others, and one whose state its owner replaces continues from there.
TEST(Bundle, RunsEndAndBeginAnewWithoutADifferenceToTheOthers) {
  Fleet fleet(build_fleet(build_soyuz(load_reference("soyuz_nominal")), 4), {});
  ASSERT_TRUE(fleet.bundle);
  for (int tick = 0; tick < 60; ++tick) {
    if (tick == 10) fleet.runs[1].goes_on = false;
    if (tick == 20)
      for (Logged* run : {fleet.alone[2].get(), fleet.together[2].get()}) run->simulation.state.bodies[0].v.x = 1e200;
    if (tick == 30)
      for (Logged* run : {fleet.alone[3].get(), fleet.together[3].get()}) run->simulation.state.bodies[0].w.y += 0.01;
    ASSERT_EQ(fleet.advance(), "") << "tick " << tick;
  }
  EXPECT_FALSE(fleet.runs[2].goes_on);
  EXPECT_EQ(fleet.together[1]->simulation.state.header->tick, 10);
  EXPECT_EQ(fleet.together[0]->simulation.state.header->tick, 60);
}

TEST(Bundle, StepsWithoutAllocating) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  Fleet fleet(build_fleet(build_soyuz(load_reference("soyuz_nominal")), 8), {});
  ASSERT_TRUE(fleet.bundle);
  const AllocationCount count;
  for (int tick = 0; tick < 300; ++tick) fleet.bundle->step(fleet.runs);
  EXPECT_EQ(count.get(), 0);
}

TEST(Bundle, IsMadeOfTwoToEightTreesOfRigidBodiesUnderOneGravity) {
  const Model boosters = build_soyuz(load_reference("soyuz_nominal"));
  const auto is_made = [](const std::vector<Model>& models) { return Fleet(models, {}).bundle.has_value(); };
  EXPECT_FALSE(is_made({boosters}));
  EXPECT_TRUE(is_made({boosters, boosters}));
  EXPECT_FALSE(is_made(std::vector<Model>(9, boosters)));
  Model elsewhere = boosters;
  elsewhere.gravity.uniform.z() -= 1;
  EXPECT_FALSE(is_made({boosters, elsewhere}));
  Model ball = build_dropped_ball(1);
  ball.gravity = boosters.gravity;
  EXPECT_TRUE(is_made({boosters, ball})) << "structures may differ";
}

}  // namespace
}  // namespace unlatch::test::bundle_test
