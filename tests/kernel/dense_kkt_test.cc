// Checks of the oracle itself: against finite differences of motions, against independently computed reference values,
// and against physical laws for any answer.
#include "tests/support/dense_kkt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/random_model.h"
#include "tests/support/reference_models.h"

namespace unlatch::test::dense_kkt_test {
namespace {

using Vector3 = Eigen::Matrix<Real, 3, 1>;
using Matrix3 = Eigen::Matrix<Real, 3, 3>;

// Fourth-order differences at h = 1e-3 s in long double: truncation some h⁴ = 1e-12 of a sixth derivative below 1e3.
constexpr Real kStep = 1e-3L;
constexpr double kDifferenceTolerance = 1e-8;
// Sums of a few hundred terms in long double, rounded to double once.
constexpr double kRoundOff = 1e-12;
// tree20.json prints its values with some 16 digits; its own dense solve loses a few of them.
constexpr double kReferenceTolerance = 1e-10;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

// Motion of a body with given speeds and accelerations at t = 0, to the second order that both determine.
struct Motion {
  Vector3 p = Vector3::Zero(), v = Vector3::Zero(), a = Vector3::Zero();
  Matrix3 C = Matrix3::Identity();
  Vector3 w = Vector3::Zero(), w_dot = Vector3::Zero();  // body axes

  Vector3 position(Real t) const { return p + t * v + t * t / 2 * a; }
  Matrix3 attitude(Real t) const {
    const Vector3 turn = t * w + t * t / 2 * w_dot;
    if (turn.norm() == 0) return C;
    return C * Eigen::AngleAxis<Real>(turn.norm(), turn.normalized()).toRotationMatrix();
  }
  Vector3 rate(Real t) const { return attitude(t) * (w + t * w_dot); }  // inertial axes
};

Motion random_motion_of(const SystemState& state, int body, const RealVector& accelerations) {
  if (body == kGround) return {};
  const DenseBodyState& b = state.bodies[at(body)];
  Motion m;
  m.p = b.p_WB.cast<Real>();
  m.v = b.v_WB.cast<Real>();
  m.C = b.q_WB.cast<Real>().toRotationMatrix();
  m.w = b.w_WB_B.cast<Real>();
  m.a = accelerations.segment<3>(6 * body);
  m.w_dot = accelerations.segment<3>(6 * body + 3);
  return m;
}

struct Pair {
  const Joint& joint;
  Motion base, follower;
  Matrix3 follower_axes;

  Real gap(int axis, Real t) const {
    const Vector3 r_i = base.position(t) + base.attitude(t) * joint.point_base.cast<Real>();
    const Vector3 r_j = follower.position(t) + follower.attitude(t) * joint.point_follower.cast<Real>();
    return (base.attitude(t) * joint.axes.col(axis).cast<Real>()).dot(r_j - r_i);
  }
  Real turn_rate(int axis, bool universal, Real t) const {
    const Matrix3 frame = base.attitude(t) * joint.rotation_axes.value_or(joint.axes).cast<Real>();
    Vector3 n = frame.col(axis);
    if (universal) n = frame.col(0).cross(Vector3(follower.attitude(t) * follower_axes.col(1))).normalized();
    return n.dot(follower.rate(t) - base.rate(t));
  }
};

template <class F>
Real first_derivative(F f) {
  return (8 * (f(kStep) - f(-kStep)) - (f(2 * kStep) - f(-2 * kStep))) / (12 * kStep);
}
template <class F>
Real second_derivative(F f) {
  return (16 * (f(kStep) + f(-kStep)) - (f(2 * kStep) + f(-2 * kStep)) - 30 * f(0)) / (12 * kStep * kStep);
}

Pair build_pair(const Model& model, const SystemState& state, const Joint& joint, const RealVector& accelerations) {
  const auto initial = [&](int body) -> Matrix3 {
    return body == kGround ? Matrix3(Matrix3::Identity()) : model.bodies[at(body)].q_WB.cast<Real>().toRotationMatrix();
  };
  const Matrix3 coincident =
      initial(joint.follower).transpose() * initial(joint.base) * joint.rotation_axes.value_or(joint.axes).cast<Real>();
  return {joint, random_motion_of(state, joint.base, accelerations),
          random_motion_of(state, joint.follower, accelerations),
          joint.follower_axes ? Matrix3(joint.follower_axes->cast<Real>()) : coincident};
}

// Moves every joint off its rows, so that no term vanishes, and into any of its modes.
SystemState disturb(const Model& model, Random& random) {
  SystemState state = build_initial_state(model);
  const auto vector = [&random](double size) {
    const double x = random.uniform(-size, size), y = random.uniform(-size, size), z = random.uniform(-size, size);
    return Eigen::Vector3d(x, y, z);
  };
  for (DenseBodyState& b : state.bodies) {
    b.p_WB += vector(0.1);
    b.v_WB += vector(1);
    b.w_WB_B += vector(1);
    const Eigen::Vector3d turn = vector(0.1);
    b.q_WB = (b.q_WB * Eigen::Quaterniond(1, turn.x(), turn.y(), turn.z())).normalized();
  }
  for (std::size_t j = 0; j < state.modes.size(); ++j) {
    state.modes[j] = random.below(static_cast<int>(model.joints[j].modes.size()));
  }
  return state;
}

TEST(DenseKkt, RowsAreTheDerivativesOfTheConstraints) {
  int rows = 0, universal_rows = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomModelOptions options;
    options.bodies = 6;
    const Model model = build_random_model(seed, options);
    Random random(seed);
    const SystemState state = disturb(model, random);
    const DenseKkt kkt = build_dense_kkt(model, state);
    RealVector accelerations(kkt.speed.size());
    for (Real& a : accelerations) a = static_cast<Real>(random.uniform(-1, 1));
    const RealVector first = kkt.rows * kkt.speed, second = kkt.rows * accelerations - kkt.bias;

    for (std::size_t k = 0; k < kkt.names.size(); ++k) {
      const Joint& joint = model.joints[at(kkt.names[k].joint)];
      const RowSet set = joint.modes[at(state.modes[at(kkt.names[k].joint)])].rows;
      const int row = kkt.names[k].row;
      const bool universal = joint.universal && (set & kRotationRows) == row_bit(kRotZ);
      const Pair pair = build_pair(model, state, joint, accelerations);
      const auto gap = [&](Real t) { return pair.gap(row, t); };
      const auto rate = [&](Real t) { return pair.turn_rate(row - kRotX, universal && row == kRotZ, t); };
      const Real expected_first = row < kRotX ? first_derivative(gap) : rate(0);
      const Real expected_second = row < kRotX ? second_derivative(gap) : first_derivative(rate);
      const auto index = static_cast<Eigen::Index>(k);
      const double scale = 1 + static_cast<double>(std::fabs(expected_second));
      EXPECT_NEAR(static_cast<double>(first(index) - expected_first), 0, kDifferenceTolerance * scale)
          << kRowNames[row];
      EXPECT_NEAR(static_cast<double>(second(index) - expected_second), 0, kDifferenceTolerance * scale)
          << kRowNames[row];
      ++rows;
      universal_rows += universal && row == kRotZ;
    }
  }
  EXPECT_GT(rows, 500);
  EXPECT_GT(universal_rows, 5);
}

// Accelerations and multipliers of a tree of twenty bodies, computed by an independent program.
TEST(DenseKkt, AgreesWithTheReferenceTree) {
  const nlohmann::json reference = load_reference("tree20");
  const Model model = build_tree20(reference);
  const SystemState state = build_initial_state(model);
  std::vector<Wrench> wrenches;
  for (std::size_t b = 0; b < 20; ++b) {
    const nlohmann::json& applied = reference["applied"][b];
    const Eigen::Vector3d torque(applied[3], applied[4], applied[5]);  // body axes
    wrenches.push_back({Eigen::Vector3d(applied[0], applied[1], applied[2]), state.bodies[b].q_WB * torque});
  }
  const DenseSolution solution = solve_accelerations(model, state, wrenches);

  double largest = 0, worst = 0;
  for (std::size_t b = 0; b < 20; ++b) {
    for (int k = 0; k < 6; ++k) {
      const double expected = reference["acc"][b][at(k)];
      const double got = k < 3 ? solution.linear[b][k] : solution.angular[b][k - 3];
      largest = std::max(largest, std::fabs(expected));
      worst = std::max(worst, std::fabs(got - expected));
    }
  }
  EXPECT_LE(worst, kReferenceTolerance * largest);
  std::printf("  accelerations: %.1e relative, condition %.0f\n", worst / largest, solution.condition);

  largest = worst = 0;
  std::size_t row = 0;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    for (int k = 0; k < kRows; ++k) {
      if (!has_row(model.joints[j].modes[0].rows, k)) continue;
      const double expected = reference["lam"][row++];
      largest = std::max(largest, std::fabs(expected));
      worst = std::max(worst, std::fabs(solution.multipliers[j][k] - expected));
    }
  }
  EXPECT_EQ(row, reference["lam"].size());
  EXPECT_LE(worst, kReferenceTolerance * largest);
  std::printf("  multipliers: %.1e relative\n", worst / largest);
}

TEST(DenseKkt, SatisfiesItsEquationsWhateverTheMassRatio) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    RandomModelOptions options;
    options.bodies = 12;
    options.mass_ratio = seed % 2 == 0 ? 1e8 : 10;
    const Model model = build_random_model(seed, options);
    const DenseSolution solution = solve_accelerations(model, build_initial_state(model), {});
    EXPECT_LE(solution.residual, kRoundOff);
    EXPECT_EQ(solution.redundant, 0);
  }
}

// Two welds in parallel: six redundant rows, and each bears half of the load.
TEST(DenseKkt, SharesLoadsBetweenRedundantRows) {
  RandomModelOptions options;
  options.bodies = 2;
  options.grounded_chance = 0;
  Model model = build_random_model(7, options);
  model.joints[0].modes = {{"weld", kPointRows | kRotationRows}};
  model.joints[0].mode = 0;
  const std::vector<Wrench> wrenches = {{{3, 1, -2}, {0.5, 2, 1}}, {}};
  const SystemState state = build_initial_state(model);
  const DenseSolution one = solve_accelerations(model, state, wrenches);
  model.joints.push_back(model.joints[0]);
  const DenseSolution two = solve_accelerations(model, build_initial_state(model), wrenches);

  EXPECT_EQ(two.redundant, 6);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_LE((one.linear[b] - two.linear[b]).norm(), kRoundOff);
    EXPECT_LE((one.angular[b] - two.angular[b]).norm(), kRoundOff);
  }
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LE((two.multipliers[j] - one.multipliers[0] / 2).norm(), kRoundOff * one.multipliers[0].norm());
  }
}

// After a perfectly plastic impulse no row moves, and a system without ground has kept both its momenta.
TEST(DenseKkt, PlasticImpulseStopsTheRowsAndKeepsTheMomenta) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    RandomModelOptions options;
    options.bodies = 8;
    options.grounded_chance = 0;
    const Model model = build_random_model(seed, options);
    Random random(seed);
    SystemState state = build_initial_state(model);
    for (std::size_t j = 0; j < state.modes.size(); ++j) {
      state.modes[j] = random.below(static_cast<int>(model.joints[j].modes.size()));
    }
    const DenseSolution impulse = solve_plastic_impulse(model, state);
    EXPECT_LE(impulse.residual, kRoundOff);
    Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      const Body& body = model.bodies[b];
      const Eigen::Vector3d change = body.mass * impulse.linear[b];
      linear += change;
      angular += body.p_WB.cross(change) + body.q_WB * (body.inertia * impulse.angular[b]);
      state.bodies[b].v_WB += impulse.linear[b];
      state.bodies[b].w_WB_B += impulse.angular[b];
    }
    const DenseKkt after = build_dense_kkt(model, state);
    if (after.names.empty()) continue;
    const double left = static_cast<double>((after.rows * after.speed).cwiseAbs().maxCoeff());
    const double size = 1 + static_cast<double>(after.rows.cwiseAbs().maxCoeff() * after.speed.cwiseAbs().maxCoeff());
    EXPECT_LE(left, kRoundOff * size);
    EXPECT_LE(linear.norm(), kRoundOff * 100);
    EXPECT_LE(angular.norm(), kRoundOff * 1000);
  }
}

TEST(RandomModel, StartsOnItsRowsAtPositionAndSpeed) {
  RowSet seen = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    const Model model = build_random_model(seed);
    const SystemState state = build_initial_state(model);
    ASSERT_GE(model.bodies.size(), 1u);
    ASSERT_LE(model.bodies.size(), 60u);
    const RealVector none = RealVector::Zero(static_cast<Eigen::Index>(6 * model.bodies.size()));
    for (const Joint& joint : model.joints) {
      EXPECT_GE(joint.modes.size(), 2u);
      const RowSet set = joint.modes[at(joint.mode)].rows;
      seen = static_cast<RowSet>(seen | set);
      const bool universal = joint.universal && (set & kRotationRows) == row_bit(kRotZ);
      const Pair pair = build_pair(model, state, joint, none);
      // Chains of 60 reach some 100 m and 100 m/s from the origin: round-off of poses in double.
      constexpr double kPlacing = 1e-11;
      for (int row = 0; row < kRows; ++row) {
        if (!has_row(set, row)) continue;
        if (row < kRotX) {
          EXPECT_NEAR(static_cast<double>(pair.gap(row, 0)), 0, kPlacing);
          EXPECT_NEAR(static_cast<double>(first_derivative([&](Real t) { return pair.gap(row, t); })), 0,
                      kDifferenceTolerance);
        } else {
          EXPECT_NEAR(static_cast<double>(pair.turn_rate(row - kRotX, universal, 0)), 0, kPlacing);
        }
      }
      // Two rotation rows have one common axis; three, all of them.
      const Matrix3 base = pair.base.C * joint.rotation_axes.value_or(joint.axes).cast<Real>();
      const Matrix3 follower = pair.follower.C * pair.follower_axes;
      for (int axis = 0; axis < 3; ++axis) {
        const RowSet others = static_cast<RowSet>(kRotationRows & ~row_bit(kRotX + axis));
        if ((set & others) != others) continue;
        EXPECT_NEAR(static_cast<double>(base.col(axis).dot(follower.col(axis))), 1, kPlacing);
      }
      if (universal) {
        EXPECT_NEAR(static_cast<double>(base.col(0).dot(follower.col(1))), 0, kPlacing);
      }
    }
  }
  EXPECT_EQ(seen, kPointRows | kRotationRows);
}

TEST(RandomModel, IsAValidModel) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    RandomModelOptions options;
    options.mass_ratio = seed % 2 == 0 ? 1e8 : 10;
    for (const ModelError& error : validate(build_random_model(seed, options))) {
      ADD_FAILURE() << "seed " << seed << ", " << error.where << ": " << error.what << "; " << error.mend;
    }
  }
}

TEST(RandomModel, KeepsTheMassRatioAndTheSeed) {
  RandomModelOptions options;
  options.bodies = 60;
  options.mass_ratio = 1e8;
  const Model one = build_random_model(3, options), same = build_random_model(3, options);
  double least = HUGE_VAL, most = 0;
  for (std::size_t b = 0; b < one.bodies.size(); ++b) {
    least = std::min(least, one.bodies[b].mass);
    most = std::max(most, one.bodies[b].mass);
    EXPECT_EQ(one.bodies[b].p_WB, same.bodies[b].p_WB);
    EXPECT_EQ(one.bodies[b].inertia, same.bodies[b].inertia);
  }
  EXPECT_GT(most / least, 1e6);
  EXPECT_LE(most / least, 1e8);
  EXPECT_NE(one.bodies[0].mass, build_random_model(4, options).bodies[0].mass);
}

}  // namespace
}  // namespace unlatch::test::dense_kkt_test
