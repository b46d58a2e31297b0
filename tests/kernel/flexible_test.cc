// Bodies with modal coordinates against the lumped masses that the modes come from, summed without inertia invariants.
#include "kernel/dynamics/flexible.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kernel/dynamics/balance.h"
#include "kernel/integration/integrator.h"
#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "tests/support/linear_algebra.h"
#include "tests/support/modal_model.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"
#include "tests/support/survival.h"

namespace unlatch::test::flexible_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAgree = 1e-10;  // relative: two formulas for the same sums, and a solve of a few unknowns

Vector3d to_eigen(const Vec3& a) { return {a.x, a.y, a.z}; }

Vector3d draw(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

// Mast of three bays, its state, and the corresponding model: body 0 is the mast, the others markers at its particles.
struct Mast {
  ModalBody lumped;
  FlexibleState state;
  Model model;
};

Mast build_mast(std::uint64_t seed, Support support, int modes, std::vector<std::size_t> particles) {
  Random random(seed);
  Mast mast{build_lattice_mast(3, modes, support), {}, {}};
  FlexibleState& s = mast.state;
  s.p_WB = draw(random, 2);
  s.v_WB = draw(random, 2);
  s.q_WB = Eigen::Quaterniond(Eigen::AngleAxisd(random.uniform(0, 3), draw(random, 1).normalized()));
  s.w_WB_B = draw(random, 1);
  s.eta.resize(modes);
  s.eta_rate.resize(modes);
  for (Index k = 0; k < modes; ++k) {
    s.eta[k] = random.uniform(-0.3, 0.3);
    s.eta_rate[k] = random.uniform(-3, 3);
  }
  Body body = build_flexible_body("mast", mast.lumped);
  body.p_WB = s.p_WB;
  body.v_WB = s.v_WB;
  body.q_WB = s.q_WB;
  body.w_WB_B = s.w_WB_B;
  body.flexible->initial = s.eta;
  body.flexible->initial_rate = s.eta_rate;
  mast.model.bodies.push_back(body);
  for (const std::size_t particle : particles) {
    Eigen::Matrix3Xd turn(3, modes);
    for (Index k = 0; k < modes; ++k) turn.col(k) = draw(random, 0.1);
    mast.model.bodies.push_back(build_marker("at" + std::to_string(particle), 0, mast.lumped, particle, turn));
  }
  return mast;
}

void evaluate_or_fail(Simulation& s) { ASSERT_EQ(evaluate_state(s), kNone); }

// Reads (v', w', η'') of body 0 in the oracle's order.
VectorXd read_acceleration(Simulation& s, int body = 0) {
  const PlanFlexible& flexible =
      s.data().flexible[static_cast<std::size_t>(s.data().bodies[static_cast<std::size_t>(body)].flexible)];
  const Spatial a = s.workspace.accelerations[static_cast<std::size_t>(body)];
  const Mat3 R = read_kinematics(s.evaluation(), body).R;
  VectorXd out(6 + flexible.modes);
  out << to_eigen(a.lin), to_eigen(transpose_times(R, a.ang)), VectorXd(flexible.modes);
  for (Index k = 0; k < flexible.modes; ++k)
    out[6 + k] = s.evaluation().auxiliary.rate[static_cast<std::size_t>(flexible.auxiliary + flexible.modes + k)];
  return out;
}

TEST(Flexible, AFreeBodyAcceleratesAsItsParticlesDo) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Mast mast =
        build_mast(seed, seed % 2 == 0 ? Support::kFree : Support::kClamped, 1 + static_cast<int>(seed % 6), {5, 14});
    const Vector3d g(0.3, -9.81, 1), push(40, -70, 25);
    mast.model.gravity.uniform = g;
    Load load;
    load.name = "push";
    load.body = 2;
    load.frame = Load::Frame::kWorld;
    load.direction = push;
    mast.model.loads.push_back(load);
    std::vector<Vector3d> forces;
    for (const double mass : mast.lumped.masses) forces.push_back(mass * g);
    forces[14] += push;
    const FlexibleAcceleration expected = calc_flexible_acceleration(mast.lumped, mast.state, forces);
    VectorXd all(6 + expected.modal.size());
    all << expected.linear, expected.angular, expected.modal;
    Simulation s(mast.model);
    evaluate_or_fail(s);
    EXPECT_LT((read_acceleration(s) - all).norm(), kAgree * all.norm()) << "seed " << seed;
  }
}

// Held by a ball joint to the ground at one particle, with a rigid body hanging on another: G M⁻¹ Gᵀ λ = c − G M⁻¹ F,
// densely.
TEST(Flexible, AHeldBodyWithALoadOnItAgreesWithADenseSolve) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const int modes = 1 + static_cast<int>(seed % 6);
    Mast mast = build_mast(seed, seed % 2 == 0 ? Support::kFree : Support::kClamped, modes, {1, 13});
    Model& model = mast.model;
    model.gravity.uniform = {0.3, -9.81, 1};
    // The ball's point is the marker's origin, so the oracle's particle; it must be at rest.
    mast.state.v_WB -= place_markers(model).bodies[1].v_WB;
    model.bodies[0].v_WB = mast.state.v_WB;
    const PointJacobian held = calc_point_jacobian(mast.lumped, mast.state, 1);
    const PointJacobian carries = calc_point_jacobian(mast.lumped, mast.state, 13);
    Body bob = box("bob", 4, 1, 2, 1.5);
    const Model placed = place_markers(model);
    const Body& marker = placed.bodies[2];
    const Vector3d arm(0.3, -0.1, 0.2);
    bob.p_WB = marker.p_WB - arm;
    bob.w_WB_B = {0.4, 0.7, -0.2};
    bob.v_WB = marker.v_WB - bob.w_WB_B.cross(arm);
    model.bodies.push_back(bob);
    Joint ground, ball;
    ground.name = "ground";
    ground.follower = 1;
    ground.point_base = placed.bodies[1].p_WB;
    ball.name = "ball";
    ball.base = 2;
    ball.follower = 3;
    ball.axes = marker.q_WB.toRotationMatrix().transpose();  // rows along the inertial axes
    ball.point_follower = arm;
    for (Joint* joint : {&ground, &ball}) joint->modes = {{"ball", kPointRows}};
    model.joints = {ground, ball};

    const Index n = 6 + modes;
    std::vector<Vector3d> forces;
    for (const double mass : mast.lumped.masses) forces.push_back(mass * model.gravity.uniform);
    const FlexibleSystem own = calc_flexible_system(mast.lumped, mast.state, forces);
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n + 6, n + 6), G = Eigen::MatrixXd::Zero(6, n + 6);
    VectorXd F(n + 6), c(6);
    M.topLeftCorner(n, n) = own.mass.cast<double>();
    M.block<3, 3>(n, n) = bob.mass * Matrix3d::Identity();
    M.block<3, 3>(n + 3, n + 3) = bob.inertia;
    F << own.force.cast<double>(), bob.mass * model.gravity.uniform, -bob.w_WB_B.cross(bob.inertia * bob.w_WB_B);
    Matrix3d arm_cross;
    arm_cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    G.topLeftCorner(3, n) = held.J.cast<double>();
    G.block(3, 0, 3, n) = -carries.J.cast<double>();
    G.block<3, 6>(3, n) << Matrix3d::Identity(), -arm_cross;
    // Row of the moving base: n·(r_f'' − …) has no terms beyond the points' accelerations when the points coincide,
    // except 2 w × v_rel, and v_rel is 0.
    c << -held.bias.cast<double>(), carries.bias.cast<double>() - bob.w_WB_B.cross(bob.w_WB_B.cross(arm));
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n + 12, n + 12);
    H << M, -G.transpose(), G, Eigen::MatrixXd::Zero(6, 6);
    VectorXd right(n + 12);
    right << F, c;
    const VectorXd expected = test::solve_full_pivots(H, right);

    for (const int root : {kNone, 3, 0}) {
      Simulation s(model, {.root = root});
      evaluate_or_fail(s);
      const Spatial bob_a = s.workspace.accelerations[3];
      VectorXd found(n + 12);
      found << read_acceleration(s), to_eigen(bob_a.lin), to_eigen(bob_a.ang), VectorXd(6);
      for (Index r = 0; r < 3; ++r) {
        found[n + 6 + r] = s.workspace.multipliers[static_cast<std::size_t>(r)];
        found[n + 9 + r] = s.workspace.multipliers[static_cast<std::size_t>(kRows + r)];
      }
      EXPECT_LT((found - expected).norm(), 1e-9 * expected.norm()) << "seed " << seed << ", root " << root;
    }
  }
}

TEST(Flexible, AFreeBodyKeepsMomentaAndUndampedItsEnergy) {
  Mast mast = build_mast(7, Support::kFree, 5, {3});
  mast.model.bodies[0].flexible->damping.setZero();
  mast.model.bodies[0].flexible->initial *= 0.1;
  mast.model.bodies[0].flexible->initial_rate *= 0.1;
  const auto calc_energy = [&](Simulation& s) {
    double energy = calc_balance(s.data(), s.state, s.evaluation()).kinetic;
    for (Index i = 0; i < 5; ++i) {
      const double eta = s.state.auxiliary[static_cast<std::size_t>(i)], w = mast.lumped.frequencies[i];
      energy += 0.5 * w * w * eta * eta;
    }
    return energy;
  };
  double errors[2];
  for (const int k : {0, 1}) {
    Simulation s(mast.model, {.dt = k == 0 ? 2e-4 : 1e-4});
    ASSERT_FALSE(s.data().flexible[0].implicit);
    evaluate_or_fail(s);
    const double energy = calc_energy(s);
    while (s.get_time() < 0.2) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    errors[k] = std::abs(calc_energy(s) - energy) / energy;
  }
  EXPECT_LT(errors[1], errors[0] / 14);  // order four or more

  Simulation s(mast.model, {.dt = 1e-5});  // so fine that the remaining error is rounding
  evaluate_or_fail(s);
  const Balance before = calc_balance(s.data(), s.state, s.evaluation());
  while (s.get_time() < 0.2) ASSERT_EQ(s.advance().status, StepStatus::kOk);
  const Balance after = calc_balance(s.data(), s.state, s.evaluation());
  EXPECT_LT(norm(after.momentum - before.momentum), 1e-12 * norm(before.momentum));
  EXPECT_LT(norm(after.angular_momentum - before.angular_momentum), 1e-12 * norm(before.angular_momentum));
}

// The velocity of a marker is the rate of change of its pose.
TEST(Flexible, AMarkersVelocityIsTheRateOfItsPose) {
  const Mast mast = build_mast(3, Support::kClamped, 4, {9});
  Simulation s(mast.model);
  const PlanMarker& marker = s.data().markers[0];
  constexpr double h = 1e-5;  // of central differences: h² against rounding / h
  const auto at = [&](double t) {
    BodyState body = s.state.bodies[0];
    body.p = body.p + t * body.v;
    const double angle = norm(body.w) * t, half = std::sin(0.5 * angle) / norm(body.w);
    body.q = body.q * Quat{std::cos(0.5 * angle), half * body.w.x, half * body.w.y, half * body.w.z};
    const VectorXd eta = mast.state.eta + t * mast.state.eta_rate;
    return calc_marker_state(s.data(), marker, body, eta.data(), mast.state.eta_rate.data());
  };
  const BodyState now = at(0), before = at(-h), after = at(h);
  EXPECT_LT(norm((0.5 / h) * (after.p - before.p) - now.v), 1e-7 * norm(now.v));
  const Quat turn = conjugate(before.q) * after.q;
  EXPECT_LT(norm((1 / h) * Vec3{turn.x, turn.y, turn.z} - now.w), 1e-6 * norm(now.w));
}

// Two masts welded tip to root, one end held: the rows hold in position and velocity through a second of swinging.
Model build_welded_masts(double stiffening) {
  Mast mast = build_mast(11, Support::kFree, 4, {0, 15});
  Model model = mast.model;
  model.bodies[0].p_WB.setZero();
  model.bodies[0].q_WB.setIdentity();
  model.bodies[0].v_WB.setZero();
  model.bodies[0].w_WB_B.setZero();
  model.bodies[0].flexible->initial.setZero();
  model.bodies[0].flexible->initial_rate.setZero();
  model.bodies[0].flexible->frequencies *= stiffening;
  model.bodies.push_back(model.bodies[0]);
  model.bodies[3].name = "outer";
  for (const int k : {1, 2}) {
    Body marker = model.bodies[static_cast<std::size_t>(k)];
    marker.name += "_outer";
    marker.marker->body = 3;
    model.bodies.push_back(marker);
  }
  model.bodies[3].p_WB = model.bodies[2].marker->position - model.bodies[1].marker->position;
  model.gravity.uniform = {0, -9.81, 2};
  Joint hinge, weld;
  hinge.name = "hinge";
  hinge.follower = 1;
  hinge.point_base = model.bodies[1].marker->position;
  hinge.modes = {{"hinge", kRevoluteRows}};
  weld.name = "weld";
  weld.base = 2;
  weld.follower = 4;
  weld.modes = {{"weld", kWeldRows}};
  model.joints = {hinge, weld};
  return model;
}

TEST(Flexible, JointsAtMarkersHold) {
  Simulation s(build_welded_masts(1));
  double swing = 0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(s.advance().status, StepStatus::kOk) << i;
    update_motion(s);
    ASSERT_LT(calc_drift(s.data(), s.state, s.evaluation()), 1e-9) << i;
    swing = std::max(swing, std::abs(s.state.auxiliary[0]));
  }
  EXPECT_GT(swing, 1e-3);  // it does bend
}

// Modes so stiff that they do not bend, integrated implicitly: the rigid run, to the order of the method.
TEST(Flexible, FrozenModesAreTheRigidRun) {
  const Model flexible = build_welded_masts(1e5);
  Model rigid;
  rigid.gravity = flexible.gravity;
  for (const int b : {0, 3}) {
    rigid.bodies.push_back(flexible.bodies[static_cast<std::size_t>(b)]);
    rigid.bodies.back().flexible.reset();
  }
  rigid.joints = flexible.joints;
  rigid.joints[0].follower = 0;
  rigid.joints[0].point_follower = flexible.bodies[1].marker->position;
  rigid.joints[1].base = 0;
  rigid.joints[1].point_base = flexible.bodies[2].marker->position;
  rigid.joints[1].follower = 1;
  rigid.joints[1].point_follower = flexible.bodies[4].marker->position;
  Simulation a(flexible), b(rigid);
  ASSERT_TRUE(a.data().flexible[0].implicit);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_EQ(a.advance().status, StepStatus::kOk) << i;
    ASSERT_EQ(b.advance().status, StepStatus::kOk);
  }
  EXPECT_LT(norm(a.state.bodies[3].p - b.state.bodies[1].p), 2e-6);
  EXPECT_LT(norm(a.state.bodies[0].w - b.state.bodies[0].w), 1e-5);
}

// With all its modes a mast that a ball joint holds at one particle swings like the lattice with that particle fixed.
TEST(Flexible, AHeldBodySwingsWithTheFrequenciesOfItsHeldLattice) {
  constexpr int kBays = 2, kAll = 12 * (kBays + 1) - 6;
  const ModalBody lumped = build_lattice_mast(kBays, kAll, Support::kFree);
  const Index dofs = 12 * (kBays + 1);
  Eigen::MatrixXd shapes(dofs, kAll);
  VectorXd mass(dofs);
  for (std::size_t i = 0; i < lumped.masses.size(); ++i) {
    shapes.middleRows<3>(static_cast<Index>(3 * i)) = lumped.shapes[i];
    mass.segment<3>(static_cast<Index>(3 * i)).setConstant(lumped.masses[i]);
  }
  // K = M Φ ω² Φᵀ M, since rigid motions have no energy; then without the first particle.
  const Eigen::MatrixXd weighted = mass.asDiagonal() * shapes;
  const Eigen::MatrixXd K = weighted * lumped.frequencies.cwiseAbs2().asDiagonal() * weighted.transpose();
  const VectorXd root = mass.tail(dofs - 3).cwiseSqrt().cwiseInverse();
  const VectorXd lattice =
      test::calc_symmetric_eigen(root.asDiagonal() * K.bottomRightCorner(dofs - 3, dofs - 3) * root.asDiagonal())
          .values.tail(kAll);  // three are turns about the particle

  Model model;
  model.bodies.push_back(build_flexible_body("mast", lumped));
  model.bodies[0].flexible->damping.setZero();
  model.bodies.push_back(build_marker("root", 0, lumped, 0, Eigen::Matrix3Xd::Zero(3, kAll)));
  Joint ball;
  ball.name = "ball";
  ball.follower = 1;
  ball.point_base = lumped.positions[0];
  ball.modes = {{"ball", kPointRows}};
  model.joints.push_back(ball);
  Simulation s(model);
  Eigen::MatrixXd A(kAll, kAll);  // η'' = −A η
  constexpr double kSmall = 1e-6;
  for (Index k = 0; k < kAll; ++k) {
    A.col(k).setZero();
    for (const double eta : {kSmall, -kSmall}) {
      init_state(s.plan, s.state);
      s.state.auxiliary[static_cast<std::size_t>(k)] = eta;
      const Vector3d away = -eta * lumped.shapes[0].col(k);  // the particle stays in place
      s.state.bodies[0].p = {away.x(), away.y(), away.z()};
      evaluate_or_fail(s);
      A.col(k) -= read_acceleration(s).tail(kAll) / (2 * eta);
    }
  }
  VectorXd found = test::calc_eigenvalues(A).real();
  std::sort(found.begin(), found.end());
  for (Index k = 0; k < kAll; ++k) EXPECT_NEAR(found[k], lattice[k], 1e-7 * lattice[k]) << "mode " << k + 1;
}

TEST(Flexible, EveryWidthOfLanesGivesTheSameBits) {
  const Model model = build_welded_masts(1);
  std::uint64_t hash = 0;
  for (const InstructionSet set :
       {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
    if (!is_supported(set)) continue;
    Simulation s(model, {.instruction_set = set});
    for (int i = 0; i < 100; ++i) ASSERT_EQ(s.advance().status, StepStatus::kOk);
    if (hash == 0) hash = calc_hash(s.state);
    EXPECT_EQ(calc_hash(s.state), hash) << get_name(set);
  }
}

TEST(Flexible, MistakesAreNamed) {
  Model model = build_mast(1, Support::kFree, 3, {2}).model;
  model.bodies[1].marker->turn.resize(3, 2);
  model.bodies[0].flexible->second[0] *= 2;
  Load load;
  load.name = "push";
  model.loads.push_back(load);
  std::string all;
  for (const ModelError& error : validate(model)) all += error.where + ": " + error.what + "\n";
  EXPECT_NE(all.find("body 'at2': its shapes are not as many as its body's modes"), std::string::npos) << all;
  EXPECT_NE(all.find("the modal mass of modes 1 and 1"), std::string::npos) << all;
  EXPECT_NE(all.find("element 'push': it acts on the flexible body 'mast' itself"), std::string::npos) << all;
}

// Modes that the step does not resolve decay.
TEST(Flexible, ModesOfAnyFrequencyStayFinite) {
  for (const double stiffening : {1.0, 1e4, 1e100}) {
    SCOPED_TRACE(stiffening);
    const ModalBody lumped = build_lattice_mast(3, 4, Support::kFree);
    Model model;
    model.bodies = {build_flexible_body("mast", lumped)};
    model.bodies[0].flexible->initial.setConstant(0.1);
    model.bodies[0].flexible->frequencies *= stiffening;
    PlanOptions options;
    options.dt = 1e-5;
    EXPECT_EQ(survive(model, 2000, options).status, StepStatus::kOk);
  }
}

}  // namespace
}  // namespace unlatch::test::flexible_test
