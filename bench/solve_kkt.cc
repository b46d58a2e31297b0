// Writes the KKT blocks of a model at its initial state, sharing nothing with the kernel but the Model, and passes them
// to the solvers of kkt.h.
#include "bench/kkt.h"
#include "bench/solve_solver.h"

namespace unlatch::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

KktBody calc_body(const Body& body, const Vector3d& gravity) {
  KktBody out;
  out.mass = body.mass;
  const Matrix3d R = body.q_WB.toRotationMatrix();
  Eigen::Map<Matrix3d>(out.inertia) = R * body.inertia * R.transpose();
  Vector3d::Map(out.force) = body.mass * gravity;
  Vector3d::Map(out.force + 3) = -(R * body.w_WB_B.cross(body.inertia * body.w_WB_B));
  return out;
}

// Rows of either kind: n·(a_f + α_f × r_f − a_b − α_b × r_b), n·(α_f − α_b).
void write_row(KktJoint& joint, bool point, const Vector3d& n, const Vector3d& r_base, const Vector3d& r_follower,
               double bias) {
  double* of_base = joint.base_rows + 6 * joint.count;
  double* of_follower = joint.follower_rows + 6 * joint.count;
  Vector3d::Map(of_follower) = point ? n : Vector3d::Zero();
  Vector3d::Map(of_follower + 3) = point ? r_follower.cross(n) : n;
  Vector3d::Map(of_base) = point ? Vector3d(-n) : Vector3d::Zero();
  Vector3d::Map(of_base + 3) = point ? Vector3d(-r_base.cross(n)) : Vector3d(-n);
  joint.bias[joint.count++] = bias;
}

// The follower's point coincides with the base's, so r_base reaches to it. It may slip along the base with d' = v_f +
// w_f × r_f − v_b − w_b × r_b, for which the base's rotation counts twice.
//   point–plane  c = −n·(w_f × (w_f × r_f) − w_b × (w_b × r_b)) − 2 (w_b × n)·d'
//   rotation     c = −n'·(w_f − w_b),  n' = w_b × n; of the universal joint n = x_b × y_f, here of unit length, and
//                n' = (w_b × x) × y + x × (w_f × y), less its part along n
KktJoint calc_joint(const Model& model, const Joint& joint) {
  const test::Placement b = test::get_placement(model, joint.base), f = test::get_placement(model, joint.follower);
  const Vector3d r_base = b.R * joint.point_base, r_follower = f.R * joint.point_follower;
  const Vector3d slip = f.v + f.w.cross(r_follower) - b.v - b.w.cross(r_base);
  const Vector3d swing = f.w.cross(f.w.cross(r_follower)) - b.w.cross(b.w.cross(r_base));
  const Matrix3d axes = b.R * joint.axes;
  const RowSet rows = joint.modes[0].rows;

  KktJoint out;
  out.base = joint.base;
  out.follower = joint.follower;
  out.count = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector3d n = axes.col(k);
    if (has_row(rows, kX + k)) write_row(out, true, n, r_base, r_follower, -n.dot(swing) - 2 * b.w.cross(n).dot(slip));
  }
  for (int k = 0; k < 3; ++k) {
    if (!has_row(rows, kRotX + k)) continue;
    const Vector3d n = axes.col(k);
    Vector3d turning = b.w.cross(n);
    if (joint.universal) {
      turning = b.w.cross(axes.col(0)).cross(axes.col(1)) + axes.col(0).cross(f.w.cross(axes.col(1)));
      turning -= n * n.dot(turning);
    }
    write_row(out, false, n, r_base, r_follower, -turning.dot(f.w - b.w));
  }
  return out;
}

KktSystem build_kkt(const Model& model) {
  KktSystem system;
  for (const Body& body : model.bodies) system.bodies.push_back(calc_body(body, model.gravity.uniform));
  for (const Joint& joint : model.joints) system.joints.push_back(calc_joint(model, joint));
  return system;
}

class Kkt final : public Solver {
 public:
  Kkt(const Model& model, std::unique_ptr<KktSolver> solver) : model_(model), solver_(std::move(solver)) {}

  void solve() override { solver_->solve(); }

  Solution build_solution() override {
    test::BodyAccelerations bodies;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const double* a = solver_->get_acceleration(static_cast<int>(b));
      bodies.linear.push_back(Vector3d::Map(a));
      bodies.angular.push_back(Vector3d::Map(a + 3));
    }
    Solution solution{calc_joint_accelerations(model_, bodies), {}};
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const double* lambda = solver_->get_multipliers(static_cast<int>(j));
      for (int r = 0; r < kRows; ++r)
        solution.multipliers.push_back(has_row(model_.joints[j].modes[0].rows, r) ? *lambda++ : 0);
    }
    return solution;
  }

 private:
  Model model_;
  std::unique_ptr<KktSolver> solver_;
};

}  // namespace

std::unique_ptr<Solver> build_textbook(const Model& model) {
  return std::make_unique<Kkt>(model, build_textbook_solver(build_kkt(model)));
}
std::unique_ptr<Solver> build_eigen_dense(const Model& model) {
  return std::make_unique<Kkt>(model, build_dense_solver(build_kkt(model)));
}
std::unique_ptr<Solver> build_eigen_sparse(const Model& model) {
  return std::make_unique<Kkt>(model, build_sparse_solver(build_kkt(model)));
}

}  // namespace unlatch::bench
