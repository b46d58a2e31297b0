// Systems with many closed loops: graphs of bodies against the equations of motion, deployable structures, positions
// where the rank of their rows drops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "kernel/dynamics/balance.h"
#include "kernel/integration/integrator.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/linkages.h"
#include "tests/support/loop_models.h"
#include "tests/support/malloc_guard.h"
#include "tests/support/mast_model.h"
#include "tests/support/random_model.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "tests/support/solve_comparison.h"
#include "unlatch/energy.h"
#include "unlatch/redundancy.h"

namespace unlatch::test::loop_graphs_test {
namespace {

constexpr double kAgreement = 1e-10;  // relative to the largest force, and to the largest acceleration

// A random tree with `loops` more joints that are open at first, so that any velocities fit.
Model build_graph(std::uint64_t seed, int bodies, int loops, Random& random) {
  RandomModelOptions options;
  options.bodies = bodies;
  Model model = build_random_model(seed, options);
  const int count = static_cast<int>(model.bodies.size());
  for (int k = 0; k < loops; ++k) {
    const int base = random.below(count), follower = (base + 1 + random.below(count - 1)) % count;
    const RowSet kinds[] = {kPointRows, kRevoluteRows, row_bit(kX), row_bit(kRotY)};
    Joint joint = build_closing_joint(model, base, follower, random);
    joint.modes = {{"open", 0}, {"closed", kinds[random.below(4)]}};
    model.joints.push_back(joint);
  }
  return model;
}

struct Residual {
  double forces = 0, rows = 0;  // of M a + w × J w − f − Gᵀ λ and of G a − c, relative to the largest of their terms
};

// The equations of motion with the kernel's accelerations and multipliers, by the matrices of the dense solver: what no
// order of elimination enters.
Residual calc_residual(const Model& model, const Simulation& s, const std::vector<Wrench>& wrenches) {
  const SystemState state = read_state(s);
  const DenseKkt kkt = build_dense_kkt(model, state);
  const KernelSolution ours = read_solution(s);
  const auto n = static_cast<Eigen::Index>(model.bodies.size());
  RealVector a(6 * n), f(6 * n), lambda(kkt.rows.rows());
  for (Eigen::Index b = 0; b < n; ++b) {
    const auto i = static_cast<std::size_t>(b);
    a.segment<3>(6 * b) = ours.linear[i].cast<Real>();
    a.segment<3>(6 * b + 3) = ours.angular[i].cast<Real>();
    const Eigen::Vector3d weight = model.bodies[i].mass * model.gravity.uniform;
    f.segment<3>(6 * b) = (wrenches[i].force + weight).cast<Real>();
    f.segment<3>(6 * b + 3) = (state.bodies[i].q_WB.conjugate() * wrenches[i].torque).cast<Real>();
  }
  for (Eigen::Index k = 0; k < lambda.size(); ++k) {
    const DenseKkt::RowName& name = kkt.names[static_cast<std::size_t>(k)];
    lambda[k] = ours.multipliers[static_cast<std::size_t>(name.joint)][name.row];
  }
  const RealVector inertial = kkt.mass * a, reaction = kkt.rows.transpose() * lambda, motion = kkt.rows * a;
  const RealVector forces = inertial - kkt.gyroscopic - f - reaction, rows = motion - kkt.bias;
  const Real force_scale = std::max<Real>(1, std::max(inertial.cwiseAbs().maxCoeff(), reaction.cwiseAbs().maxCoeff()));
  Residual out;
  out.forces = static_cast<double>(forces.cwiseAbs().maxCoeff() / force_scale);
  if (rows.size() > 0)
    out.rows = static_cast<double>(rows.cwiseAbs().maxCoeff() / std::max<Real>(1, a.cwiseAbs().maxCoeff()));
  return out;
}

TEST(LoopGraphs, SatisfyTheEquationsOfMotion) {
  Residual worst;
  int redundant = 0, most = 0;
  for (std::uint64_t seed = 900; seed < 960; ++seed) {
    Random random(seed);
    const int bodies = seed % 6 == 0 ? 100 + random.below(101) : 2 + random.below(40);
    const int loops = random.below(std::min(101, bodies));
    Model model = build_graph(seed, bodies, loops, random);
    const std::vector<Wrench> wrenches = add_random_loads(model, random);
    Simulation s(model);
    for (std::size_t j = 0; j < model.joints.size(); ++j)
      if (model.joints[j].modes.back().name == "closed") s.state.joints[j].mode = 1;
    update_motion(s);
    ASSERT_EQ(apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()), kNone) << "seed " << seed;
    ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << "seed " << seed;
    const Residual r = calc_residual(model, s, wrenches);
    EXPECT_LT(r.forces, kAgreement) << "seed " << seed << ", " << bodies << " bodies, " << loops << " loops";
    EXPECT_LT(r.rows, kAgreement) << "seed " << seed << ", " << bodies << " bodies, " << loops << " loops";
    worst = {std::max(worst.forces, r.forces), std::max(worst.rows, r.rows)};
    redundant += s.evaluation().loop_redundant > 0 ? 1 : 0;
    most = std::max(most, loops);
  }
  std::printf("60 graphs with up to %d loops, %d with redundant rows: forces to %.1e, rows to %.1e\n", most, redundant,
              worst.forces, worst.rows);
  EXPECT_GT(redundant, 10);
  EXPECT_GT(most, 60);
}

TEST(LoopGraphs, AMastHasThreeRedundantRowsALoopAndEqualSharesOnBothSides) {
  for (const int units : {2, 3, 8, 40}) {
    const Model model = build_mast(units);
    Simulation s(model);
    ASSERT_EQ(s.advance().redundant, 3 * (units - 1)) << units;
    const Residual r = calc_residual(model, s, std::vector<Wrench>(model.bodies.size()));
    EXPECT_LT(std::max(r.forces, r.rows), kAgreement) << units;
  }
}

TEST(LoopGraphs, AMastInFreeMotionKeepsItsEnergy) {
  constexpr int kUnits = 10;
  constexpr double kWeight = 0.05;  // m/s²: within ten seconds no bar comes to lie along the mast
  Model model = build_mast(kUnits, 0.9);
  model.gravity.uniform = {0, -kWeight, 0};
  Simulation s(model);
  const auto calc = [&] {
    const EnergyFlow flow = calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0});
    double height = 0;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) height += s.state.bodies[b].p.y;
    return flow.kinetic + kWeight * height;  // masses of 1 kg
  };
  ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk);
  const double before = calc();
  double largest = 0, kinetic = 0;
  for (int i = 0; i < 10000; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk) << i;
    if (i % 100 != 0) continue;
    largest = std::max(largest, std::abs(calc() - before));
    kinetic = std::max(kinetic, calc_energy_flow(s.plan, s.state, s.workspace, {0, 0, 0}).kinetic);
  }
  std::printf("energy kept to %.1e of %.3g J over ten seconds\n", largest, kinetic);
  EXPECT_GT(kinetic, 0.5);
  EXPECT_LT(largest, 1e-6 * kinetic);
}

TEST(LoopGraphs, AnyJointOfAMastLocksAndLetsGoWithoutAllocation) {
  if (!kCountsAllocations) GTEST_SKIP() << "this build's sanitizer owns malloc";
  const Model model = build_mast(12);
  Simulation s(model);
  Random random(7);
  std::vector<int> changes;
  for (int i = 0; i < 200; ++i) changes.push_back(random.below(3 * static_cast<int>(model.joints.size() - 1)));
  const AllocationCount allocations;
  bool good = true;
  for (const int change : changes) {
    s.state.joints[1 + static_cast<std::size_t>(change / 3)].mode = change % 3;
    update_motion(s);
    good = good && apply_impulse(s.data(), Source::kNothing, s.state, s.evaluation()) == kNone;
    for (int k = 0; k < 3; ++k) good = good && s.advance().status == StepStatus::kOk;
  }
  EXPECT_EQ(allocations.get(), 0);
  EXPECT_TRUE(good);
  const Residual r = calc_residual(model, s, std::vector<Wrench>(model.bodies.size()));
  EXPECT_LT(std::max(r.forces, r.rows), kAgreement);
}

TEST(LoopGraphs, LaddersFourBarsRingsAndLatticesSatisfyTheEquationsOfMotion) {
  for (Model model : {build_ladder(12), build_four_bars(12), build_pantograph_ring(6), build_pantograph_ring(11),
                      build_lattice(3, 8), build_lattice(10, 10)}) {
    model.gravity.uniform = {0.3, -1, 0.5};  // across their planes too, where rows are redundant
    Simulation s(model);
    for (int i = 0; i < 20; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk) << model.name << " " << i;
    const Residual r = calc_residual(model, s, std::vector<Wrench>(model.bodies.size()));
    EXPECT_LT(std::max(r.forces, r.rows), kAgreement) << model.name << " of " << model.bodies.size();
  }
}

// Rows of the present modes that follow from the others, by the singular values of all of them.
int count_redundant(const Model& model, const Simulation& s) {
  constexpr double kVanishing = 1e-9;  // beside the largest
  const DenseKkt kkt = build_dense_kkt(model, read_state(s));
  const Eigen::VectorXd sizes = calc_singular_values(kkt.rows.cast<double>());
  return static_cast<int>(kkt.rows.rows() - (sizes.array() > kVanishing * sizes[0]).count());
}

TEST(LoopGraphs, HaveAsManyRedundantRowsAsTheirRankLeaves) {
  for (const Model& model :
       {build_mast(6), build_ladder(5), build_four_bars(4), build_pantograph_ring(5), build_lattice(3, 3)}) {
    Simulation s(model);
    const int expected = count_redundant(model, s);
    EXPECT_EQ(s.advance().redundant, expected) << model.name;
    EXPECT_GT(expected, 0) << model.name;
  }
}

// Cranks of parallelograms on the ground, beside each other, that lie along them: each linkage may fold or go on.
Model build_dead_centres(int linkages) {
  Model model;
  model.gravity.uniform = {0, -1, 0};
  for (int i = 0; i < linkages; ++i) {
    const Eigen::Vector3d p0(0, 0, i), p1(1, 0, i), p2(2, 0, i), z(0, 0, 1);
    const int crank = 3 * i;
    model.bodies.push_back(build_rod("crank" + std::to_string(i), p0, p1));
    model.bodies.push_back(build_rod("coupler" + std::to_string(i), p1, p2));
    model.bodies.push_back(build_rod("rocker" + std::to_string(i), p1, p2));
    model.joints.push_back(build_hinge(model, kGround, crank, p0, z));
    model.joints.push_back(build_hinge(model, crank, crank + 1, p1, z));
    model.joints.push_back(build_hinge(model, kGround, crank + 2, p1, z));
    model.joints.push_back(build_hinge(model, crank + 1, crank + 2, p2, z));
  }
  return model;
}

TEST(LoopGraphs, AtTheirDeadCentresFourBarsDoWhatEachDoesAlone) {
  constexpr double kSame = 1e-9;  // m, rad: one linkage has a dense matrix, several are eliminated where they close
  constexpr int kLinkages = 3;
  const Model one = build_dead_centres(1), many = build_dead_centres(kLinkages);
  for (const double speed : {0.0, 3.0}) {  // rad/s, of the crank and the rocker; the coupler translates
    Simulation alone(one), beside(many);
    for (Simulation* s : {&alone, &beside})
      for (std::size_t b = 0; b < s->state.bodies.size(); ++b) {
        s->state.bodies[b].v = {0, (b % 3 == 1 ? 1 : 0.5) * speed, 0};
        s->state.bodies[b].w = {0, 0, b % 3 == 1 ? 0 : speed};
      }
    EXPECT_EQ(count_redundant(many, beside), kLinkages * count_redundant(one, alone));
    for (int i = 0; i < 400; ++i) {
      const StepReport a = alone.advance(), b = beside.advance();
      ASSERT_EQ(b.status, a.status) << "step " << i << " at " << speed;
      if (a.status != StepStatus::kOk) break;
      ASSERT_EQ(b.redundant, kLinkages * a.redundant) << "step " << i << " at " << speed;
      for (std::size_t k = 0; k < beside.state.bodies.size(); ++k) {
        const Vec3 d = beside.state.bodies[k].p - alone.state.bodies[k % 3].p;
        ASSERT_LT(std::hypot(d.x, d.y), kSame) << "step " << i << " at " << speed;
      }
      if (i > 0) continue;
      const Residual r = calc_residual(many, beside, std::vector<Wrench>(many.bodies.size()));
      EXPECT_LT(std::max(r.forces, r.rows), kAgreement) << speed;
    }
  }
}

TEST(LoopGraphs, AMastThatIsFullyClosedOrOpenHasFiniteReactionsOrSaysThatItIsSingular) {
  constexpr double kHalfTurn = 3.14159265358979323846;
  for (const double angle : {0.5 * kHalfTurn, 0.0})
    for (const int units : {2, 3, 8}) {
      const Model model = build_mast(units, angle);
      Simulation s(model);
      const int expected = count_redundant(model, s);
      ASSERT_EQ(update_outputs(s.plan, {s.commands}, s.state, s.workspace), StepStatus::kOk) << units << " " << angle;
      EXPECT_EQ(s.evaluation().loop_redundant, expected) << units << " units at " << angle;
      EXPECT_GT(expected, 3 * (units - 1)) << "more than in any other position";
      const Residual r = calc_residual(model, s, std::vector<Wrench>(model.bodies.size()));
      EXPECT_LT(std::max(r.forces, r.rows), kAgreement) << units << " units at " << angle;
      for (int i = 0; i < 50 && s.advance().status == StepStatus::kOk; ++i)
        for (const auto& body : s.state.bodies) ASSERT_TRUE(std::isfinite(body.p.x + body.w.z)) << i;
    }
}

TEST(LoopGraphs, RedundantReactionsOfAMastAreSteadyAlongAMotion) {
  Model model = build_mast(8, 0.9);
  model.gravity.uniform = {0, -0.1, -1};  // across the plane: what only redundant rows bear
  Simulation s(model);
  double largest = 0, roughest = 0;
  std::vector<double> before, last;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(s.advance().redundant, 3 * 7) << i;
    std::vector<double> now;
    for (std::size_t j = 0; j < model.joints.size(); ++j)
      for (std::size_t r = 0; r < kRows; ++r) now.push_back(s.workspace.multipliers.get(j, r));
    for (std::size_t k = 0; k < now.size() && i >= 2; ++k) {
      largest = std::max(largest, std::abs(now[k]));
      roughest = std::max(roughest, std::abs(now[k] - 2 * last[k] + before[k]));
    }
    before = std::move(last);
    last = std::move(now);
  }
  std::printf("largest reaction %.3g, second difference from step to step %.1e\n", largest, roughest);
  EXPECT_GT(largest, 5);
  EXPECT_LT(roughest, 1e-4 * largest);
}

TEST(LoopGraphs, TheFrontierAndTheCostOfABodyDoNotGrowWithTheLength) {
  const auto check = [](const char* name, const Model& few, const Model& many) {
    const Plan small = compile_or_throw(few, {}), large = compile_or_throw(many, {});
    const auto per_body = [](const Plan& plan, const Model& model) {
      return static_cast<double>(calc_loop_cost(plan).loops) / static_cast<double>(model.bodies.size());
    };
    std::printf("%s: at most %d loops open at a body, %.0f multiplications a body for them\n", name,
                large.get_loop_overlap().widest, per_body(large, many));
    EXPECT_EQ(large.get_loop_overlap().widest, small.get_loop_overlap().widest) << name;
    EXPECT_LT(per_body(large, many), 1.1 * per_body(small, few)) << name;
    EXPECT_TRUE(large.get_loop_overlap().local) << name;
  };
  check("mast", build_mast(32), build_mast(512));
  check("ladder", build_ladder(32), build_ladder(512));
  check("four-bars", build_four_bars(32), build_four_bars(512));
  check("ring", build_pantograph_ring(32), build_pantograph_ring(256));
  check("lattice of width 5", build_lattice(5, 30), build_lattice(5, 120));
}

TEST(LoopGraphs, ALatticeHasAFrontierAsWideAsItIs) {
  for (const int width : {2, 5, 10, 20}) {
    const int widest = compile_or_throw(build_lattice(width, width), {}).get_loop_overlap().widest;
    std::printf("%d nodes wide: at most %d loops open at a body\n", width, widest);
    EXPECT_LE(widest, 2 * width) << width;
    EXPECT_GE(widest, width - 1) << width;
  }
}

TEST(LoopGraphs, ClustersAreCounted) {
  EXPECT_EQ(calc_loop_cost(compile_or_throw(build_mast(9), {})).clusters, 1);
  EXPECT_EQ(calc_loop_cost(compile_or_throw(build_dead_centres(4), {})).clusters, 4);
  EXPECT_EQ(calc_loop_cost(compile_or_throw(build_dead_centres(1), {})).clusters, 1);
  EXPECT_EQ(calc_loop_cost(compile_or_throw(build_mast(1), {})).clusters, 0);
  EXPECT_EQ(calc_loop_cost(compile_or_throw(build_mast(1), {})).loops, 0);
}

TEST(LoopGraphs, MemoryOfAMastGrowsWithItsLength) {
  const auto calc = [](int units) {
    const Model model = build_mast(units);
    const Plan plan = compile_or_throw(model, {});
    return static_cast<double>(plan.get_workspace_bytes()) / (2.0 * units);
  };
  const double few = calc(100), many = calc(10000);
  std::printf("workspace %.0f bytes a body with 100 units, %.0f with 10000\n", few, many);
  EXPECT_LT(many, 1.05 * few);
}

// The largest difference of the bars' directions from those of the first unit: a mast has one angle for all.
double calc_spread(const Simulation& s) {
  double largest = 0;
  for (std::size_t b = 2; b < s.state.bodies.size(); ++b) {
    const Vec3 x = column(rotation_matrix(s.state.bodies[b].q), 0),
               first = column(rotation_matrix(s.state.bodies[b % 2].q), 0);
    largest = std::max(largest, norm(x - first));
  }
  return largest;
}

// The least independent row of a cantilever mast moves only what is outboard of its loop: its pivot falls with the cube
// of the length, to 1e-11 of the row's own entry.
TEST(LoopGraphs, AMastOfTenThousandUnitsMovesAsOne) {
  for (const double angle : {0.3, 1.0, 1.5}) {
    constexpr int kUnits = 10000;
    Model model = build_mast(kUnits, angle);
    Simulation s(model);
    for (int i = 0; i < 3; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk);
      EXPECT_EQ(report.redundant, 3 * (kUnits - 1)) << angle;
    }
    for (const RedundantRows& rows : list_redundant_rows(s.plan, s.state, s.workspace)) EXPECT_EQ(rows.nearly, 0);
    const double spread = calc_spread(s), drift = calc_drift(s.plan, s.state, s.workspace);
    std::printf("angle %.1f rad: directions of 20000 bars equal to %.1e, joints closed to %.1e m\n", angle, spread,
                drift);
    EXPECT_LT(spread, 1e-12);
    EXPECT_LT(drift, 1e-9);
  }
}

// Rounding grows with the ring: the last loop leads around all of it.
TEST(LoopGraphs, RingsKeepTheirRankAsTheyGrow) {
  for (const int cells : {18, 60, 160, 400}) {
    Simulation s(build_pantograph_ring(cells));
    for (int i = 0; i < 20; ++i) {
      const StepReport report = s.advance();
      ASSERT_EQ(report.status, StepStatus::kOk) << cells;
      EXPECT_EQ(report.redundant, 6 * cells + 7) << cells << " cells, step " << i;
    }
    std::printf("%d cells: joints closed to %.1e m\n", cells, calc_drift(s.plan, s.state, s.workspace));
  }
}

// A ring whose axes are given with six digits: rigid bodies would not let it move. It moves, and the row that is not
// held is counted. Axes that are farther off lock it.
TEST(LoopGraphs, RowsThatFollowFromTheOthersOnlyNearlyAreCounted) {
  const auto list = [](double off) {
    Model model = build_pantograph_ring(6);
    for (std::size_t j = 1; j < model.joints.size(); ++j)
      model.joints[j].axes = (Eigen::AngleAxisd(off, Eigen::Vector3d::UnitX()) * model.joints[j].axes).eval();
    Simulation s(model);
    EXPECT_EQ(s.advance().status, StepStatus::kOk);
    return list_redundant_rows(s.plan, s.state, s.workspace).at(0);
  };
  const std::int32_t redundant = list(0).redundant;
  EXPECT_EQ(list(0).nearly, 0);
  EXPECT_EQ(list(3e-7).redundant, redundant);
  EXPECT_EQ(list(3e-7).nearly, 1);
  EXPECT_LT(list(1e-4).redundant, redundant);
  EXPECT_EQ(list(1e-4).nearly, 0);
}

}  // namespace
}  // namespace unlatch::test::loop_graphs_test
