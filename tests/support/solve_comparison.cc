#include "tests/support/solve_comparison.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "kernel/joints/kinematics.h"

namespace unlatch::test {
namespace {

using Eigen::Vector3d;

Vector3d to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }

Vector3d draw(Random& random, double size) {
  const double x = random.uniform(-size, size), y = random.uniform(-size, size), z = random.uniform(-size, size);
  return {x, y, z};
}

// Difference of two lists of vectors, relative to the largest entry of the second, or to 1.
template <class A, class B>
double calc_difference(const A& a, const B& b, double& size) {
  double difference = a.size() == b.size() ? 0 : HUGE_VAL;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double d = (a[i] - b[i]).cwiseAbs().maxCoeff();
    difference = d <= difference ? difference : d;  // NaN counts as a difference
    size = std::max(size, b[i].cwiseAbs().maxCoeff());
  }
  return difference;
}

template <class A>
Disagreement compare_all(const A& a, const DenseSolution& b) {
  double size = 1, lambda_size = 1;
  const double linear = calc_difference(a.linear, b.linear, size);
  const double angular = calc_difference(a.angular, b.angular, size);
  const double lambda = calc_difference(a.multipliers, b.multipliers, lambda_size);
  return {std::max(linear, angular) / size, lambda / lambda_size};
}

RealVector calc_row_forces(const DenseKkt& kkt, const std::vector<Eigen::Matrix<double, 6, 1>>& multipliers) {
  RealVector lambda(static_cast<Eigen::Index>(kkt.names.size()));
  for (std::size_t k = 0; k < kkt.names.size(); ++k)
    lambda(static_cast<Eigen::Index>(k)) =
        static_cast<Real>(multipliers[static_cast<std::size_t>(kkt.names[k].joint)](kkt.names[k].row));
  return kkt.rows.transpose() * lambda;
}

// Changes everything by a relative `size` at random; attitudes stay, since rotated frames have the same effect.
Model disturb(Model model, double size, Random& random) {
  const auto turn = [&] {
    const Vector3d r = draw(random, size);
    return Eigen::Quaterniond(1, r.x(), r.y(), r.z()).normalized().toRotationMatrix();
  };
  for (Body& body : model.bodies) {
    body.mass *= 1 + random.uniform(-size, size);
    const Vector3d scale = Vector3d::Ones() + draw(random, size);
    body.inertia = (scale.asDiagonal() * body.inertia * scale.asDiagonal()).eval();
  }
  for (Joint& joint : model.joints) {
    const Eigen::Matrix3d rotation_axes = joint.rotation_axes.value_or(joint.axes);
    joint.point_base += draw(random, size * joint.point_base.norm());
    joint.point_follower += draw(random, size * joint.point_follower.norm());
    joint.axes = turn() * joint.axes;
    joint.rotation_axes = turn() * rotation_axes;
  }
  return model;
}

SystemState disturb(SystemState state, double size, Random& random) {
  for (DenseBodyState& body : state.bodies) {
    body.v_WB += draw(random, size * body.v_WB.norm());
    body.w_WB_B += draw(random, size * body.w_WB_B.norm());
  }
  return state;
}

}  // namespace

KernelSolution read_solution(const Simulation& simulation) {
  const Workspace& ws = simulation.workspace;
  KernelSolution solution;
  for (std::size_t b = 0; b < ws.accelerations.size(); ++b) {
    const Spatial a = ws.accelerations[b];
    solution.linear.push_back(to_eigen(a.lin));
    solution.angular.push_back(
        to_eigen(transpose_times(read_kinematics(simulation.evaluation(), static_cast<int>(b)).R, a.ang)));
  }
  for (std::size_t j = 0; j < simulation.data().joints.size(); ++j) {
    Eigen::Matrix<double, 6, 1> lambda;
    for (std::size_t r = 0; r < kRows; ++r) lambda[static_cast<Eigen::Index>(r)] = ws.multipliers[kRows * j + r];
    solution.multipliers.push_back(lambda);
  }
  return solution;
}

SystemState read_state(const Simulation& simulation) {
  SystemState state;
  for (const BodyState& b : simulation.state.bodies)
    state.bodies.push_back(
        {to_eigen(b.p), to_eigen(b.v), Eigen::Quaterniond(b.q.w, b.q.x, b.q.y, b.q.z), to_eigen(b.w)});
  for (const JointState& joint : simulation.state.joints) state.modes.push_back(static_cast<int>(joint.mode));
  return state;
}

std::vector<Wrench> add_random_loads(Model& model, Random& random) {
  constexpr double kSize = 30;  // N, N m
  std::vector<Wrench> wrenches(model.bodies.size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    wrenches[b] = {draw(random, kSize), draw(random, kSize)};
    for (const bool torque : {false, true}) {
      Load load;
      load.name = (torque ? "torque" : "force") + std::to_string(b);
      load.body = static_cast<int>(b);
      load.kind = torque ? Load::Kind::kTorque : Load::Kind::kForce;
      load.frame = Load::Frame::kWorld;
      load.direction = torque ? wrenches[b].torque : wrenches[b].force;
      model.loads.push_back(load);
    }
  }
  return wrenches;
}

Disagreement compare(const KernelSolution& kernel, const DenseSolution& dense) { return compare_all(kernel, dense); }
Disagreement compare(const DenseSolution& a, const DenseSolution& b) { return compare_all(a, b); }

Disagreement compare_row_forces(const KernelSolution& kernel, const DenseSolution& dense, const DenseKkt& kkt) {
  Disagreement out = compare_all(kernel, dense);
  const RealVector ours = calc_row_forces(kkt, kernel.multipliers), theirs = calc_row_forces(kkt, dense.multipliers);
  const double size = std::max(1.0, static_cast<double>(theirs.cwiseAbs().maxCoeff()));
  out.multipliers = static_cast<double>((ours - theirs).cwiseAbs().maxCoeff()) / size;
  return out;
}

double calc_condition(const Model& model, const SystemState& state, const std::vector<Wrench>& wrenches,
                      Random& random) {
  constexpr double kDisturbance = 1e-11;  // far above the oracle's rounding, and small enough for a linear change
  constexpr int kDraws = 3;
  const DenseSolution exact = solve_accelerations(model, state, wrenches);
  double condition = 1;
  for (int i = 0; i < kDraws; ++i) {
    std::vector<Wrench> loads = wrenches;
    for (Wrench& w : loads) {
      w.force += draw(random, kDisturbance * w.force.norm());
      w.torque += draw(random, kDisturbance * w.torque.norm());
    }
    const DenseSolution other =
        solve_accelerations(disturb(model, kDisturbance, random), disturb(state, kDisturbance, random), loads);
    condition = std::max(condition, compare(other, exact).get_worst() / kDisturbance);
  }
  return condition;
}

}  // namespace unlatch::test
