// Blows on bodies that stand on more rough feet than hold them: random landings, stools on tables.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>
#include <vector>

#include "tests/support/malloc_guard.h"
#include "tests/support/reference_models.h"
#include "tests/support/rigid_models.h"
#include "tests/support/simulation.h"
#include "unlatch/contacts.h"
#include "unlatch/energy.h"

namespace unlatch::test::rigid_blows_test {
namespace {

// A block on `feet` rough feet, 1 to 6, that lands tilted and turning on a floor.
template <class Draw>
Model build_random_landing(const Draw& draw, int feet) {
  Model model = build_rigid_feet();
  const double xs[] = {-0.25, 0.25, -0.25, 0.25, 0, 0}, ys[] = {-0.125, 0.125, 0.125, -0.125, 0.2, -0.2};
  model.surfaces[1].shapes.clear();
  for (int i = 0; i < feet; ++i) model.surfaces[1].shapes.push_back(build_sphere(0.125, {xs[i], ys[i], -0.125}));
  model.contacts[0].restitution = 0.3 + 0.3 * draw();
  model.contacts[0].friction = 0.5 + 0.4 * draw();
  Body& block = model.bodies[0];
  block.p_WB.z() += 0.06;
  block.q_WB = Eigen::Quaterniond(1, 0.05 * draw(), 0.05 * draw(), draw()).normalized();
  block.v_WB = {draw(), draw(), -1 + 0.5 * draw()};
  block.w_WB_B = {2 * draw(), 2 * draw(), 2 * draw()};
  model.events.clear();
  add_contact_events(model);
  return model;
}

double calc_energy(Simulation& s, const Model& model) {
  EXPECT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  double sum = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0}).kinetic;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) sum += model.bodies[b].mass * kGravity * s.state.bodies[b].p.z;
  for (std::size_t c = 0; c < model.contacts.size(); ++c)
    sum += get_contact_totals(s.plan, s.state, static_cast<int>(c)).dissipated;
  return sum;
}

// What the forces of closed pairs lack of Coulomb's law, N: that pull, or that are out of their cones.
double calc_lack(const Simulation& s, const Model& model) {
  double lack = 0;
  for (std::size_t i = 0; i < s.state.contacts.size(); ++i) {
    const Contact& contact = model.contacts[static_cast<std::size_t>(s.data().contact_pairs[i].contact)];
    const double normal = s.state.rigid_forces[i], side = norm(s.state.rigid_frictions[i]);
    lack = std::max({lack, -normal, side - contact.friction * normal});
  }
  return lack;
}

struct Outcome {
  bool refused = false;
  int touches = 0, postponed = 0;
  double gain = -1, balance = 0, lack = 0, yielded = 0;
};

Outcome fly(const Model& model, int ticks) {
  Outcome out;
  Simulation s(model);
  const double before = calc_energy(s, model);
  for (int i = 0; i < ticks; ++i) {
    const StepReport report = s.advance();
    if (report.status != StepStatus::kOk) {
      EXPECT_EQ(report.status, StepStatus::kRigidContact);
      EXPECT_GE(report.contact, 0);
      out.refused = true;
      return out;
    }
    out.postponed += report.postponed;
    EXPECT_EQ(report.yielded > 0, report.yielding >= 0);
    out.yielded = std::max(out.yielded, report.yielded);
    for (const EventAudit& audit : report.audits) out.gain = std::max(out.gain, audit.allowed.kinetic);
    for (const FiredEvent& fired : report.events) out.touches += fired.event % 2 == 0 ? 1 : 0;
    out.lack = std::max(out.lack, calc_lack(s, model));
  }
  out.balance = std::abs(calc_energy(s, model) - before) / before;
  return out;
}

constexpr double kGain = 1e-11;      // J: rounding
constexpr double kBalance = 1e-5;    // of the energy: steps of 1 ms
constexpr double kLack = 1e-9;       // N: rounding
constexpr double kPostponed = 1e-3;  // likewise where a touch waited for a tick, goes deeper until then, and is lifted

struct Sum {
  int refused = 0, touches = 0, yielded = 0;
  double lack = 0;
  void add(const Outcome& out) {
    refused += out.refused ? 1 : 0;
    touches += out.touches;
    EXPECT_LE(out.gain, kGain);
    EXPECT_LE(out.balance, out.postponed > 0 ? kPostponed : kBalance);
    lack = std::max(lack, out.lack);
    EXPECT_LE(out.yielded, 1e-3);
    yielded += out.yielded > 0 ? 1 : 0;
  }
};

TEST(RigidBlows, NearlyAllLandingsOnRoughFeetAreFlown) {
  for (const int feet : {1, 2, 3, 4, 6}) {
    Sum sum;
    for (unsigned seed = 0; seed < 100; ++seed) {
      std::mt19937_64 random(seed + 1000U * static_cast<unsigned>(feet));
      sum.add(fly(build_random_landing([&] { return std::uniform_real_distribution<>(-1, 1)(random); }, feet), 300));
    }
    EXPECT_EQ(sum.yielded > 0, feet > 4) << feet << " feet";  // reported: places that contradict each other
    EXPECT_LE(sum.refused, feet > 4 ? 2 : feet > 3 ? 1 : 0) << feet << " feet";
    EXPECT_GT(sum.touches, 400);
    EXPECT_LE(sum.lack, kLack);
    std::cout << feet << " feet: " << sum.refused << " refused, " << sum.touches << " touches, lack " << sum.lack
              << " N\n";
  }
}

void expect_stools_to_fly(int count) {
  Sum sum;
  for (unsigned seed = 0; seed < static_cast<unsigned>(count); ++seed) {
    std::mt19937_64 random(seed);
    Model model = build_random_stool([&] { return std::uniform_real_distribution<>(-1, 1)(random); }, 0.3 * (seed % 3));
    for (Contact& contact : model.contacts) contact.friction = 0.1 + 0.2 * (seed % 4);
    sum.add(fly(model, 1000));
  }
  EXPECT_LE(8 * sum.refused, count);
  EXPECT_GT(sum.touches, 25 * count);
  EXPECT_LE(sum.lack, kLack);
  std::cout << "stools: " << sum.refused << " refused, " << sum.touches << " touches, lack " << sum.lack << " N\n";
}

TEST(RigidBlows, StoolsOnARoughTableOnFourLegsAreMostlyFlown) { expect_stools_to_fly(16); }
TEST(LongRigidBlows, FortyStoolsOnARoughTableOnFourLegsAreMostlyFlown) { expect_stools_to_fly(40); }

// tests/references/rough_feet_reference.py tries all combinations of feet that leave, stick and slip.
TEST(RigidBlows, AFlatFallOnThreeFeetAgreesWithAnIndependentSolution) {
  const nlohmann::json blow = load_reference("rough_feet")["blow"];
  Model model = build_rigid_feet();
  model.gravity.uniform = {0, 0, 0};
  const double height = 1e-4;
  model.surfaces[1].shapes = {build_sphere(0.125, {-0.25, -0.2, -0.125}), build_sphere(0.125, {0.25, -0.1, -0.125}),
                              build_sphere(0.125, {0.05, 0.2, -0.125})};
  model.contacts[0].friction = 0.6;
  model.contacts[0].restitution = 0.3;
  model.bodies[0].p_WB.z() += height;
  model.bodies[0].v_WB = {-0.55, 0.65, -0.8};
  model.bodies[0].w_WB_B = {0, 0, 3};
  model.bodies[0].q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(-3 * height / 0.8, Eigen::Vector3d::UnitZ()));
  model.events.clear();
  add_contact_events(model);
  Simulation s(model);
  ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const std::vector<double> velocity = blow["velocity"], spin = blow["spin"];
  const BodyState& body = s.state.bodies[0];
  constexpr double kTime = 1e-6;  // m/s: the touch is located to 1e-6 of the step
  constexpr double kTurn = 2e-3;  // rad/s: what a free block's spin changes by from the touch to the tick
  const Vec3 w = rotation_matrix(body.q) * body.w;
  EXPECT_NEAR(norm(body.v - Vec3{velocity[0], velocity[1], velocity[2]}), 0, kTime);
  EXPECT_NEAR(norm(w - Vec3{spin[0], spin[1], spin[2]}), 0, kTurn);
}

TEST(RigidBlows, AStickSlipOfFourFeetAgreesWithAnIndependentIntegration) {
  const nlohmann::json run = load_reference("rough_feet")["run"];
  Model model = build_rigid_feet();
  model.contacts[0].friction = 0.3;
  Load push;
  push.name = "push";
  push.direction = {1, 0, 0};
  push.profile.kind = Profile::Kind::kTable;
  push.profile.times = {0, 0.4, 1, 2};
  push.profile.values = {0, 10, -2, -12};
  model.loads.push_back(push);
  Simulation s(model);
  for (int i = 0; i < 2000; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk) << i;
  EXPECT_NEAR(s.state.bodies[0].p.x, run["place"].get<double>(), 1e-6);
  EXPECT_NEAR(s.state.bodies[0].v.x, run["speed"].get<double>(), 1e-6);
}

// Blows on six feet, which Newton's method solves.
TEST(RigidBlows, EveryWidthGivesTheSameBitsWithoutAllocation) {
  std::mt19937_64 random(6000);
  const Model model = build_random_landing([&] { return std::uniform_real_distribution<>(-1, 1)(random); }, 6);
  std::vector<std::uint64_t> hashes;
  for (const InstructionSet set : {InstructionSet::kScalar, InstructionSet::kAuto}) {
    Simulation s(model, {.instruction_set = set});
    const AllocationCount count;
    for (int i = 0; i < 300; ++i) EXPECT_EQ(s.advance().status, StepStatus::kOk) << i;
    const auto allocations = count.get();
    EXPECT_TRUE(allocations == 0 || !kCountsAllocations) << allocations;
    hashes.push_back(calc_hash(s.state));
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace unlatch::test::rigid_blows_test
