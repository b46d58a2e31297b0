// Properties of every step, for any model.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include "kernel/dynamics/balance.h"
#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "tests/golden/golden_models.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/random_model.h"
#include "tests/support/reference_models.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "unlatch/frequencies.h"

namespace unlatch::test::step_test {
namespace {

Model build_boosters() { return build_soyuz(load_reference("soyuz_nominal")); }

std::vector<std::uint64_t> run_hashes(Simulation& simulation, int ticks) {
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < ticks; ++i) {
    EXPECT_EQ(simulation.advance().status, StepStatus::kOk);
    hashes.push_back(calc_hash(simulation.state));
  }
  return hashes;
}

constexpr int kAllPhases = 900;  // ticks of 1 ms: the boosters pass hinge, slider, contact, nozzle and free flight

TEST(Step, DoesNotAllocateInAnyPhase) {
  if (!kCountsAllocations) GTEST_SKIP() << "a sanitizer's malloc cannot be counted";
  Simulation boosters(build_boosters()), array(build_solar(load_reference("solar_elastic")));
  const AllocationCount count;
  for (int i = 0; i < kAllPhases; ++i) (void)boosters.advance();
  for (int i = 0; i < 9000; ++i) (void)array.advance();  // both latches
  EXPECT_EQ(count.get(), 0);
  EXPECT_EQ(boosters.state.joints[3].mode, 2);
}

bool are_equal(const auto& a, const auto& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<std::uint64_t>(double{a[i]}) != std::bit_cast<std::uint64_t>(double{b[i]})) return false;
  return true;
}

// The step continues from the results of the step before in the workspace, or, in another workspace, computes them
// anew.
TEST(Step, ContentOfTheWorkspaceBeforeDoesNotMatter) {
  for (const GoldenModel& golden : build_golden_models()) {
    SCOPED_TRACE(golden.model.name);
    PlanOptions options;
    options.dt = golden.dt;
    Simulation clean(golden.model, options), dirty(golden.model, options);
    std::byte* const first = reinterpret_cast<std::byte*>(&get_data(dirty.workspace));
    const std::size_t bytes = dirty.plan.get_workspace_bytes();
    for (int i = 0; i < golden.ticks; ++i) {
      std::fill_n(reinterpret_cast<double*>(first), bytes / sizeof(double), std::numeric_limits<double>::quiet_NaN());
      dirty.workspace = Workspace(dirty.plan, {first, bytes});
      // The second of three commands differs, so that inputs change between steps.
      for (Simulation* s : {&clean, &dirty})
        for (double& command : s->commands) command = i % 3 == 1 ? 0.5 : 1;
      ASSERT_EQ(clean.advance().status, StepStatus::kOk);
      ASSERT_EQ(dirty.advance().status, StepStatus::kOk);
      ASSERT_EQ(calc_hash(clean.state), calc_hash(dirty.state)) << "tick " << i;
      ASSERT_TRUE(are_equal(clean.workspace.multipliers, dirty.workspace.multipliers)) << "tick " << i;
      ASSERT_TRUE(are_equal(clean.workspace.sensors, dirty.workspace.sensors)) << "tick " << i;
    }
  }
}

void poison(std::span<double> numbers) { std::ranges::fill(numbers, std::numeric_limits<double>::quiet_NaN()); }

// Only the final evaluation outlives a step: neither the search for events, nor the stages, nor the solver's scratch.
TEST(Step, OnlyTheFinalEvaluationIsKeptForTheNextStep) {
  for (const GoldenModel& golden : build_golden_models()) {
    SCOPED_TRACE(golden.model.name);
    PlanOptions options;
    options.dt = golden.dt;
    Simulation clean(golden.model, options), poisoned(golden.model, options);
    const PlanData& plan = poisoned.data();
    Evaluation& ev = poisoned.evaluation();
    const EventSearch& search = get_data(poisoned.workspace).search;
    for (int i = 0; i < golden.ticks; ++i) {
      for (const std::span<double> numbers :
           {search.guards_low, search.guards_high, search.guards_middle, search.rates_low, search.rates_high,
            search.tolerances, search.stack, ev.loop_loads, ev.loop_replies, ev.loop_column, ev.loop_solution,
            ev.rotation_sines, ev.rotation_cosines, ev.auxiliary.start, ev.auxiliary.first, ev.auxiliary.sum})
        poison(numbers);
      std::memset(search.acting.data(), 0xff, search.acting.size_bytes());
      for (const BodyEight& eight : plan.eights) {
        BodyBlock<Wide<kEight>>& body = eight.get_body(ev.blocks.data(), 0);
        const auto first = reinterpret_cast<double*>(&body.start), end = reinterpret_cast<double*>(&body.R);
        poison({first, end});
      }
      constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
      for (CompliantSpring& spring : ev.compliant) spring = {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN};
      ASSERT_EQ(clean.advance().status, StepStatus::kOk);
      ASSERT_EQ(poisoned.advance().status, StepStatus::kOk);
      ASSERT_TRUE(get_data(poisoned.workspace).kept.is_of(poisoned.state)) << "tick " << i;
      ASSERT_EQ(calc_hash(clean.state), calc_hash(poisoned.state)) << "tick " << i;
      ASSERT_TRUE(are_equal(clean.workspace.multipliers, poisoned.workspace.multipliers)) << "tick " << i;
    }
  }
}

// One workspace accepts states of any tick in any order: with equal modes and with other modes.
TEST(Step, AWorkspaceServesStatesOfOtherTicks) {
  for (const GoldenModel& golden : build_golden_models()) {
    SCOPED_TRACE(golden.model.name);
    PlanOptions options;
    options.dt = golden.dt;
    Simulation run(golden.model, options), used(golden.model, options);
    constexpr int kStates = 16;
    std::vector<std::vector<std::byte>> states;
    for (int i = 0; i < golden.ticks; ++i) {
      if (i % (golden.ticks / kStates + 1) == 0) {
        const std::span<const std::byte> bytes = run.state.get_bytes();
        states.emplace_back(bytes.begin(), bytes.end());
      }
      ASSERT_EQ(run.advance().status, StepStatus::kOk);
    }
    for (std::size_t i = 0; i < 3 * states.size(); ++i) {
      const std::vector<std::byte>& bytes = states[i * 7 % states.size()];
      Simulation fresh(golden.model, options);
      for (Simulation* s : {&used, &fresh}) std::memcpy(s->state.get_bytes().data(), bytes.data(), bytes.size());
      ASSERT_EQ(update_outputs(used.plan, {used.commands}, used.state, used.workspace),
                update_outputs(fresh.plan, {fresh.commands}, fresh.state, fresh.workspace));
      ASSERT_TRUE(are_equal(used.workspace.multipliers, fresh.workspace.multipliers)) << "state " << i;
      ASSERT_EQ(used.advance().status, fresh.advance().status);
      ASSERT_EQ(calc_hash(used.state), calc_hash(fresh.state)) << "state " << i;
    }
  }
}

// A state that was changed between two steps is not mistaken for the result of the previous step.
TEST(Step, AChangedStateCounts) {
  Simulation changed(build_boosters()), fresh(build_boosters());
  for (Simulation* s : {&changed, &fresh}) ASSERT_EQ(s->advance().status, StepStatus::kOk);
  for (Simulation* s : {&changed, &fresh}) s->state.bodies[2].w.x += 1e-12;
  get_data(fresh.workspace).kept.valid = false;
  for (Simulation* s : {&changed, &fresh}) ASSERT_EQ(s->advance().status, StepStatus::kOk);
  EXPECT_EQ(calc_hash(changed.state), calc_hash(fresh.state));
  Simulation same(build_boosters());
  for (int i = 0; i < 2; ++i) ASSERT_EQ(same.advance().status, StepStatus::kOk);
  EXPECT_NE(calc_hash(changed.state), calc_hash(same.state));
}

// An event within some roundings of a tick ends the step at the tick's own time, where the next one begins.
TEST(Step, EventsNextToATickEndTheStepAtTheTick) {
  const int tick = 700;  // of the sliding phase
  Simulation before(build_boosters());
  while (before.state.header->tick < tick) ASSERT_EQ(before.advance().status, StepStatus::kOk);
  const double place = before.evaluation().coordinates[find_coordinate(before.data(), 0, kX)];
  for (int ulps = -40; ulps <= 40; ++ulps) {
    Model model = build_soyuz(load_reference("soyuz_nominal"));
    for (Event& event : model.events)
      if (event.when.kind == Condition::Kind::kDisplacement) event.when.threshold = place * (1 + ulps * 0x1p-52);
    Simulation follows(model), anew(model);
    int events = 0;
    while (follows.state.header->tick < tick + 5) {
      const StepReport report = follows.advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      if (follows.state.header->tick >= tick - 1) events += static_cast<int>(report.events.size());
      get_data(anew.workspace).kept.valid = false;
      ASSERT_EQ(anew.advance().status, StepStatus::kOk);
      ASSERT_EQ(calc_hash(follows.state), calc_hash(anew.state)) << ulps << " at " << follows.state.header->tick;
    }
    EXPECT_GE(events, 1) << ulps;
  }
}

TEST(Step, ARestoredStateGoesTheSameWayAgain) {
  Simulation simulation(build_boosters());
  std::vector<std::byte> saved;
  for (int i = 0; i < kAllPhases; ++i) {
    const std::span<std::byte> bytes = simulation.state.get_bytes();
    saved.assign(bytes.begin(), bytes.end());
    ASSERT_EQ(simulation.advance().status, StepStatus::kOk);
    const std::uint64_t first = calc_hash(simulation.state);
    std::copy(saved.begin(), saved.end(), bytes.begin());
    ASSERT_EQ(simulation.advance().status, StepStatus::kOk);
    ASSERT_EQ(calc_hash(simulation.state), first) << "tick " << i;
  }
}

TEST(Step, AddressesDoNotMatter) {
  const Model model = build_boosters();
  Simulation here(model);
  const Plan moved_plan = here.plan;
  std::vector<double> state_memory(moved_plan.get_state_bytes() / 8 + 1);
  Block workspace_memory(moved_plan.get_workspace_bytes() + 640);
  State state(moved_plan, {reinterpret_cast<std::byte*>(state_memory.data() + 1), moved_plan.get_state_bytes()});
  Workspace workspace(moved_plan, workspace_memory.get().subspan(576));
  init_state(moved_plan, state);
  for (int i = 0; i < kAllPhases; ++i) {
    ASSERT_EQ(here.advance().status, StepStatus::kOk);
    ASSERT_EQ(step(moved_plan, {here.commands}, state, workspace).status, StepStatus::kOk);
    ASSERT_EQ(calc_hash(state), calc_hash(here.state)) << "tick " << i;
  }
}

TEST(Step, TwoThreadsShareOnePlan) {
  Simulation alone(build_boosters());
  const Plan& plan = alone.plan;
  std::uint64_t hashes[2] = {0, 0};
  {
    std::vector<std::jthread> threads;
    for (std::uint64_t& hash : hashes)
      threads.emplace_back([&plan, &hash] {
        Block state_memory(plan.get_state_bytes()), workspace_memory(plan.get_workspace_bytes());
        State state(plan, state_memory.get());
        Workspace workspace(plan, workspace_memory.get());
        init_state(plan, state);
        for (int i = 0; i < kAllPhases; ++i) (void)step(plan, {}, state, workspace);
        hash = calc_hash(state);
      });
  }
  const std::uint64_t expected = run_hashes(alone, kAllPhases).back();
  EXPECT_EQ(hashes[0], expected);
  EXPECT_EQ(hashes[1], expected);
}

TEST(Step, AFaultLeavesTheLastGoodState) {
  Model model = build_pendulum(true, 1);
  Load wild;
  wild.name = "wild";
  wild.direction = {1e308, 1e308, 0};
  wild.profile.value = 1e308;
  wild.on = false;
  model.loads.push_back(wild);
  Action on;
  on.kind = Action::Kind::kSwitch;
  on.value = 1;
  model.events.push_back({"go wild", "bar", when_time(0.0055), 0, {on}, false});
  Simulation simulation(model);
  run_hashes(simulation, 5);
  const std::uint64_t before = calc_hash(simulation.state);
  const StepReport report = simulation.advance();
  EXPECT_EQ(report.status, StepStatus::kNotFinite);
  EXPECT_EQ(calc_hash(simulation.state), before);
  EXPECT_EQ(simulation.state.header->tick, 5);
}

// Free systems without dissipation: momenta to rounding, energy to the order of the method, rows to rounding.
TEST(Step, KeepsMomentaEnergyAndJointsOfRandomFreeSystems) {
  constexpr double kMomentum = 1e-10, kEnergy = 1e-6, kDrift = 1e-11;  // relative; a second of motion at 1 ms
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    RandomModelOptions options;
    options.bodies = 2 + static_cast<int>(seed % 9);
    options.grounded_chance = 0;
    const Model model = build_random_model(seed, options);
    Simulation s(model);
    update_motion(s);
    const Balance before = calc_balance(s.data(), s.state, s.evaluation());
    double drift = 0;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(s.advance().status, StepStatus::kOk) << "seed " << seed << " tick " << i;
      drift = std::max(drift, calc_drift(s.data(), s.state, s.evaluation()));
    }
    update_motion(s);
    const Balance after = calc_balance(s.data(), s.state, s.evaluation());
    EXPECT_LT(norm(after.momentum - before.momentum), kMomentum * (1 + norm(before.momentum))) << "seed " << seed;
    EXPECT_LT(norm(after.angular_momentum - before.angular_momentum),
              kMomentum * (1 + norm(before.angular_momentum)) * 100)
        << "seed " << seed;
    EXPECT_LT(std::abs(after.kinetic - before.kinetic), kEnergy * before.kinetic) << "seed " << seed;
    EXPECT_LT(drift, kDrift) << "seed " << seed;
  }
}

// The simple pendulum of the IFToMM multibody benchmark library (problem A01): a point mass on a massless bar of 1 m.
TEST(Step, FollowsTheBenchmarkPendulum) {
  constexpr double kPosition = 1e-8;  // m; ten seconds at 1 ms
  Model model;
  model.bodies.push_back(box("mass", 1, 1e-12, 1e-12, 1e-12));
  model.bodies[0].p_WB = {-1, 0, 0};
  model.gravity.uniform = {0, -9.81, 0};
  Joint joint;
  joint.name = "pivot";
  joint.point_follower = {1, 0, 0};
  joint.modes = {{"revolute", kRevoluteRows}};
  model.joints.push_back(joint);
  Simulation s(model);
  run_hashes(s, 10000);
  EXPECT_NEAR(s.state.bodies[0].p.x, -0.275087462576117, kPosition);
  EXPECT_NEAR(s.state.bodies[0].p.y, -0.961419205099125, kPosition);
}

TEST(Step, KnowsHowFastALatchSwings) {
  const Model model = build_solar(load_reference("solar_elastic"));
  Simulation s(model);
  const std::vector<ElementFrequency> found = calc_frequencies(s.plan, s.state, s.workspace);
  ASSERT_EQ(found.size(), 4u);
  // A drive and its latch act on the same degree of freedom, so their frequencies have the ratio of the roots of their
  // stiffnesses.
  const double drive = model.joint_springs[0].stiffness, latch = model.joint_springs[1].stiffness;
  EXPECT_NEAR(found[1].omega / found[0].omega, std::sqrt(latch / drive), 1e-12);
  // The outer panel alone, turning about its hinge, is the slowest motion that the second latch could have to hold.
  EXPECT_GT(found[3].omega, std::sqrt(900 / (4.99 + 11 * 1.0013)));
}

}  // namespace
}  // namespace unlatch::test::step_test
