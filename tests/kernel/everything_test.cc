// Random systems with all features: trees of all joint kinds, springs that are integrated implicitly, a flexible mast
// among the rigid bodies, a loop through it; against one dense system of equations that is independent of the solver:
//
//   [M + Σ κ gᵀg   −Gᵀ] [a]   [F + Σ gᵀ (e + κ c_g)]
//   [G               0] [λ] = [c                    ]
//
// g: the Jacobian row of a spring's coordinate, ẍ = g a − c_g; e: its effort; κ: term of the implicit method. Markers
// are bodies without mass, tied to the mast by six more rows each.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/forces.h"
#include "kernel/dynamics/varying.h"
#include "kernel/elements/compliance.h"
#include "kernel/elements/kinds/load.h"
#include "kernel/solver/loops/loop_rows.h"
#include "tests/support/modal_model.h"
#include "tests/support/random.h"
#include "tests/support/random_model.h"
#include "tests/support/simulation.h"

namespace unlatch::test::everything_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kModes = 4, kMarkers = 3;
constexpr double kStep = 1e-3;  // s

Vector3d draw(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}
Eigen::Quaterniond draw_attitude(Random& random) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(random.uniform(0, 3), draw(random, 1).normalized()));
}
Vec3 to_vec(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }
Vector3d to_eigen(const Vec3& a) { return {a.x, a.y, a.z}; }

struct System {
  Model model;
  ModalBody lumped;
  int mast = 0;  // its markers follow it
};

// A joint of random kind whose point and axes fit the present places of the two bodies.
Joint connect(const Model& model, const std::string& name, int base, int follower, const Vector3d& point,
              Random& random) {
  static const RowSet kKinds[] = {0b111111, 0b011111, 0b000111, 0b111011, 0b101111, 0b011011, 0b000011, 0b100111};
  const Body &b = model.bodies[static_cast<std::size_t>(base)], &f = model.bodies[static_cast<std::size_t>(follower)];
  Joint joint;
  joint.name = name;
  joint.base = base;
  joint.follower = follower;
  joint.point_base = b.q_WB.conjugate() * (point - b.p_WB);
  joint.point_follower = f.q_WB.conjugate() * (point - f.p_WB);
  joint.axes = draw_attitude(random).toRotationMatrix();
  joint.modes = {{"on", kKinds[random.below(8)]}, {"free", 0}};
  return joint;
}

System build_system(std::uint64_t seed) {
  Random random(seed);
  System s{build_random_model(seed, {.bodies = 2 + random.below(7)}),
           build_lattice_mast(2, kModes, seed % 2 == 0 ? Support::kFree : Support::kClamped), 0};
  Model& model = s.model;
  const int rigid = static_cast<int>(model.bodies.size());
  for (Body& body : model.bodies) {  // at rest; the test sets speeds that are independent of the joints
    body.v_WB.setZero();
    body.w_WB_B.setZero();
  }
  s.mast = rigid;
  Body mast = build_flexible_body("mast", s.lumped);
  mast.q_WB = draw_attitude(random);
  // A bent mast has particles for markers; a straight one has markers that turn, by formulas that hold without bending.
  const bool bent = random.chance(0.5);
  if (bent) mast.flexible->initial = Eigen::VectorXd::NullaryExpr(kModes, [&] { return random.uniform(-0.3, 0.3); });
  model.bodies.push_back(mast);
  for (const std::size_t particle : {0u, 6u, 11u}) {
    Eigen::Matrix3Xd turn = Eigen::Matrix3Xd::Zero(3, kModes);
    for (Index k = 0; k < kModes && !bent; ++k) turn.col(k) = draw(random, 0.2);
    model.bodies.push_back(build_marker("m" + std::to_string(particle), s.mast, s.lumped, particle, turn));
  }
  const int host = random.below(rigid);
  const Body& carrier = model.bodies[static_cast<std::size_t>(host)];
  const Vector3d point = carrier.p_WB + draw(random, 1);
  Model placed = place_markers(model);
  model.bodies[static_cast<std::size_t>(s.mast)].p_WB +=
      point - placed.bodies[static_cast<std::size_t>(s.mast) + 1].p_WB;
  placed = place_markers(model);
  model.joints.push_back(connect(placed, "to_mast", host, s.mast + 1, point, random));
  Body bob;
  bob.name = "bob";
  bob.mass = 3;
  bob.inertia = Vector3d(1, 1.5, 2).asDiagonal();
  bob.q_WB = draw_attitude(random);
  bob.p_WB = placed.bodies[static_cast<std::size_t>(s.mast) + 2].p_WB + draw(random, 1);
  model.bodies.push_back(bob);
  placed = place_markers(model);
  model.joints.push_back(connect(placed, "to_bob", s.mast + 2, s.mast + 1 + kMarkers, bob.p_WB, random));
  if (random.chance(0.5)) {
    Joint loop = connect(placed, "loop", random.below(rigid), s.mast + 3,
                         placed.bodies[static_cast<std::size_t>(s.mast) + 3].p_WB, random);
    loop.modes[0].rows = kPointRows;
    model.joints.push_back(loop);
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {  // a stiff spring along a free coordinate
    const Joint& joint = model.joints[j];
    const RowSet rows = joint.modes[static_cast<std::size_t>(joint.mode)].rows;
    const int axis = random.below(kRows);
    if (joint.universal || joint.name == "loop" || has_row(rows, axis) || random.chance(0.4)) continue;
    JointSpring spring;
    spring.name = "spring" + std::to_string(j);
    spring.joint = static_cast<int>(j);
    spring.axis = axis;
    spring.effort = random.uniform(-5, 5);
    spring.stiffness = std::pow(10, random.uniform(2, 8));
    spring.damping = random.uniform(0, 20);
    spring.implicit = true;
    model.joint_springs.push_back(spring);
  }
  return s;
}

// Dense system in its own unknowns: (v', w') per body, then the modal ones.
struct Dense {
  RealMatrix M, G;
  RealVector F, c;
};

void append_rows(Dense& d, const RealMatrix& rows, const RealVector& bias) {
  const Index before = d.G.rows();
  d.G.conservativeResize(before + rows.rows(), d.M.cols());
  d.G.bottomRows(rows.rows()) = rows;
  d.c.conservativeResize(before + rows.rows());
  d.c.tail(rows.rows()) = bias;
}

RealMatrix cross_matrix(const Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m.cast<Real>();
}

Dense build_dense(const System& s, const Model& placed, const SystemState& state, const FlexibleState& mast) {
  Model rigid = placed;  // the rows of joints need bodies with some mass, which is removed again
  for (Body& body : rigid.bodies) {
    body.flexible.reset();
    if (!body.marker) continue;
    body.marker.reset();
    body.mass = 1;
    body.inertia.setIdentity();
  }
  const DenseKkt kkt = build_dense_kkt(rigid, state);
  const Index n = kkt.mass.rows();
  Dense d{RealMatrix::Zero(n + kModes, n + kModes), RealMatrix(0, n + kModes), RealVector::Zero(n + kModes),
          RealVector(0)};
  d.M.topLeftCorner(n, n) = kkt.mass;
  d.F.head(n) = kkt.gyroscopic;
  for (int k = 0; k <= kMarkers; ++k) {
    d.M.middleRows(6 * (s.mast + k), 6).setZero();
    d.F.segment(6 * (s.mast + k), 6).setZero();
  }
  const FlexibleSystem own = calc_flexible_system(s.lumped, mast, {});
  const Index at = 6 * s.mast;
  d.M.block(at, at, 6, 6) = own.mass.topLeftCorner(6, 6);
  d.M.block(at, n, 6, kModes) = own.mass.topRightCorner(6, kModes);
  d.M.block(n, at, kModes, 6) = own.mass.bottomLeftCorner(kModes, 6);
  d.M.block(n, n, kModes, kModes) = own.mass.bottomRightCorner(kModes, kModes);
  d.F.segment(at, 6) = own.force.head(6);
  d.F.tail(kModes) = own.force.tail(kModes);
  RealMatrix rows = RealMatrix::Zero(kkt.rows.rows(), n + kModes);
  rows.leftCols(n) = kkt.rows;
  append_rows(d, rows, kkt.bias);

  const RealMatrix R = mast.q_WB.toRotationMatrix().cast<Real>();
  for (int k = 0; k < kMarkers; ++k) {
    const std::size_t particle = std::vector<std::size_t>{0, 6, 11}[static_cast<std::size_t>(k)];
    const std::size_t body = static_cast<std::size_t>(s.mast + 1 + k);
    const PointJacobian point = calc_point_jacobian(s.lumped, mast, particle);
    const RealMatrix turn = placed.bodies[body].marker->turn.cast<Real>();  // straight: Ψ' = Ψ
    const RealMatrix R_marker = state.bodies[body].q_WB.toRotationMatrix().cast<Real>();
    RealMatrix tie = RealMatrix::Zero(6, n + kModes);
    tie.block(0, 6 * (s.mast + 1 + k), 3, 3).setIdentity();
    tie.block(0, at, 3, 6) = -point.J.leftCols(6);
    tie.block(0, n, 3, kModes) = -point.J.rightCols(kModes);
    tie.block(3, 6 * (s.mast + 1 + k) + 3, 3, 3) = R_marker;
    tie.block(3, at + 3, 3, 3) = -R;
    tie.block(3, n, 3, kModes) = -R * turn;
    RealVector bias(6);
    const RealVector w = R * mast.w_WB_B.cast<Real>(), w_rel = R * turn * mast.eta_rate.cast<Real>();
    bias << point.bias, cross_matrix(w.cast<double>()) * w_rel;
    append_rows(d, tie, bias);
  }
  return d;
}

// Gradient of the angle about a spring's axis over the speeds of the rigid bodies, where more than that rotation is
// free: the twist is 2 atan(v_k / w) of the relative quaternion (w, v), and v' = (w ω + ω × v)/2, w' = −ω · v/2.
// Otherwise `row`, that of the axis.
RealVector calc_twist_gradient(const Model& placed, const SystemState& state, const JointSpring& spring,
                               const RealVector& row) {
  const Joint& joint = placed.joints[static_cast<std::size_t>(spring.joint)];
  const RowSet rows = joint.modes[static_cast<std::size_t>(joint.mode)].rows;
  const int k = spring.axis - kRotX;
  if (k < 0 || ((rows | row_bit(spring.axis)) & kRotationRows) == kRotationRows) return row;
  const auto get_attitude = [&](int body) -> Eigen::Matrix3d {
    if (body == kGround) return Eigen::Matrix3d::Identity();
    return state.bodies[static_cast<std::size_t>(body)].q_WB.toRotationMatrix();
  };
  const auto get_first_attitude = [&](int body) -> Eigen::Matrix3d {
    if (body == kGround) return Eigen::Matrix3d::Identity();
    return placed.bodies[static_cast<std::size_t>(body)].q_WB.toRotationMatrix();
  };
  const Eigen::Matrix3d base = get_attitude(joint.base), follower = get_attitude(joint.follower),
                        axes = joint.rotation_axes.value_or(joint.axes),
                        carried = joint.follower_axes.value_or(get_first_attitude(joint.follower).transpose() *
                                                               get_first_attitude(joint.base) * axes);
  const Eigen::Quaterniond q((base * axes).transpose() * (follower * carried));
  const Eigen::Vector3d v = q.vec(), e = Eigen::Vector3d::Unit(k);
  const double w = q.w();
  const Eigen::Vector3d gradient = base * axes * (w * w * e + w * v.cross(e) + v[k] * v) / (w * w + v[k] * v[k]);
  RealVector out = RealVector::Zero(row.size());
  out.segment(6 * joint.follower + 3, 3) += (follower.transpose() * gradient).cast<Real>();
  if (joint.base != kGround) out.segment(6 * joint.base + 3, 3) -= (base.transpose() * gradient).cast<Real>();
  return out;
}

// Adds an implicit spring: its pivot is that of the joint's row, as if it were active; its effort is along that row or
// the gradient of its angle.
void add_spring(Dense& d, const Model& placed, const SystemState& state, const JointSpring& spring, double x) {
  Model rigid = placed;
  for (Body& body : rigid.bodies) {
    body.flexible.reset();
    if (!body.marker) continue;
    body.marker.reset();
    body.mass = 1;
    body.inertia.setIdentity();
  }
  Joint& joint = rigid.joints[static_cast<std::size_t>(spring.joint)];
  joint.modes = {{"spring", row_bit(spring.axis)}};
  SystemState alone = state;
  alone.modes[static_cast<std::size_t>(spring.joint)] = 0;
  const DenseKkt kkt = build_dense_kkt(rigid, alone);
  for (std::size_t i = 0; i < kkt.names.size(); ++i) {
    if (kkt.names[i].joint != spring.joint) continue;
    const RealVector g = kkt.rows.row(static_cast<Index>(i)).transpose();
    const Real lead = static_cast<Real>(kGamma) * static_cast<Real>(kStep);
    const Real k = static_cast<Real>(spring.stiffness), damping = static_cast<Real>(spring.damping),
               pivot = lead * (lead * k + damping);
    const Index n = g.size();
    const RealVector twist = calc_twist_gradient(placed, state, spring, g);
    const Real rate = twist.dot(kkt.speed);
    const Real effort =
        static_cast<Real>(spring.effort) - k * static_cast<Real>(x - spring.rest) - damping * rate - lead * k * rate;
    d.M.topLeftCorner(n, n) += pivot * g * g.transpose();
    d.F.head(n) += twist * effort + g * (pivot * kkt.bias[static_cast<Index>(i)]);
  }
}

TEST(Everything, AtOnceAgreesWithADenseSolve) {
  constexpr int kSystems = 1000;
  constexpr double kAgree = 1e-10;  // relative, of accelerations; springs to 1e8 N/m add some digits' loss
  int compared = 0, springs = 0, loops = 0;
  double worst = 0;
  for (std::uint64_t seed = 7000; seed < 7000 + kSystems; ++seed) {
    const System s = build_system(seed);
    Simulation sim(s.model, {.dt = kStep});
    Random random(seed ^ 0x5a5a);
    for (auto& body : sim.state.bodies) {
      body.v = to_vec(draw(random, 1));
      body.w = to_vec(draw(random, 1));
    }
    for (double& extra : sim.state.auxiliary.subspan(kModes, kModes)) extra = random.uniform(-2, 2);
    const PlanData& plan = sim.data();
    Evaluation& ev = sim.evaluation();
    load_state(plan, sim.state, ev);
    const Implicit implicit = begin_compliance(plan, sim.state, 0, kStep, ev);
    update_masses(plan, 0, KnotSide::kAfter, ev);
    update_kinematics(plan, ev);
    store_motion(plan, ev, sim.state);  // markers move with the mast
    const Inputs inputs{sim.commands};
    const Instant now{plan, inputs, sim.state, 0, implicit};
    update_loads(now, ev);
    update_joints(plan, sim.state, RowTarget::kAcceleration, ev);
    update_coordinates(plan, sim.state, CoordinateSet::kAll, ev);
    update_forces(now, ev);
    ASSERT_EQ(get_kernels(plan).factor_and_solve(plan, sim.state, ev, {.gamma_h = implicit.gamma_h}, kAllRows), kNone)
        << seed;

    const Model placed = place_markers(s.model);
    SystemState state = build_initial_state(placed);
    for (std::size_t b = 0; b < state.bodies.size(); ++b) {
      const auto& from = sim.state.bodies[b];
      state.bodies[b] = {
          to_eigen(from.p), to_eigen(from.v), {from.q.w, from.q.x, from.q.y, from.q.z}, to_eigen(from.w)};
    }
    const auto& m = state.bodies[static_cast<std::size_t>(s.mast)];
    FlexibleState mast{m.p_WB, m.v_WB, m.q_WB, m.w_WB_B, Eigen::VectorXd(kModes), Eigen::VectorXd(kModes)};
    for (std::size_t k = 0; k < kModes; ++k) {
      mast.eta[static_cast<Index>(k)] = sim.state.auxiliary[k];
      mast.eta_rate[static_cast<Index>(k)] = sim.state.auxiliary[kModes + k];
    }
    Dense d = build_dense(s, placed, state, mast);
    for (const JointSpring& spring : s.model.joint_springs)
      add_spring(d, placed, state, spring, ev.coordinates[find_coordinate(sim.data(), spring.joint, spring.axis)]);
    const Index n = d.M.rows(), rows = d.G.rows();
    RealMatrix H = RealMatrix::Zero(n + rows, n + rows);
    H << d.M, -d.G.transpose(), d.G, RealMatrix::Zero(rows, rows);
    RealVector right(n + rows);
    right << d.F, d.c;
    const Eigen::FullPivLU<RealMatrix> lu(H);
    if (lu.rank() < H.rows()) continue;  // redundant rows: multipliers are not unique, and Loops.* compare those
    const RealVector expected = lu.solve(right);
    Real error = 0, size = 0;
    for (std::size_t b = 0; b < state.bodies.size(); ++b) {
      const Spatial a = sim.workspace.accelerations[b];
      const Index i = static_cast<Index>(6 * b);
      const RealVector turn = state.bodies[b].q_WB.toRotationMatrix().cast<Real>() * expected.segment(i + 3, 3);
      error += (to_eigen(a.lin).cast<Real>() - expected.segment(i, 3)).squaredNorm() +
               (to_eigen(a.ang).cast<Real>() - turn).squaredNorm();
      size += expected.segment(i, 6).squaredNorm();
    }
    const double relative = static_cast<double>(std::sqrt(error / size));
    EXPECT_LT(relative, kAgree) << "seed " << seed;
    worst = std::max(worst, relative);
    ++compared;
    springs += static_cast<int>(sim.data().compliant.size());
    loops += sim.data().loops.empty() ? 0 : 1;
  }
  std::printf("%d random systems from seed 7000, %d with loops, %d implicit springs: worst disagreement %.1e\n",
              compared, loops, springs, worst);
  EXPECT_GT(compared, kSystems / 2);
}

}  // namespace
}  // namespace unlatch::test::everything_test
