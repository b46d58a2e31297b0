// Writes the KKT blocks of a model at its initial state, sharing nothing with the kernel but the Model, and hands them
// to the solvers of kkt.h.
#include "bench/kkt.h"
#include "bench/solve_solver.h"

namespace unlatch::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
static_assert(kKktRows == kHingeRows);

KktBody calc_body(const Body& body, const Vector3d& gravity) {
  KktBody out;
  out.mass = body.mass;
  const Matrix3d R = body.q_WB.toRotationMatrix();
  Eigen::Map<Matrix3d>(out.inertia) = R * body.inertia * R.transpose();
  Vector3d::Map(out.force) = body.mass * gravity;
  Vector3d::Map(out.force + 3) = -(R * body.w_WB_B.cross(body.inertia * body.w_WB_B));
  return out;
}

// n·(a_f + α_f × r_f − a_b − α_b × r_b) = −n·(w_f × (w_f × r_f) − w_b × (w_b × r_b)) at the common point, and
// n·(α_f − α_b) = −(w_b × n)·(w_f − w_b).
KktHinge calc_hinge(const Model& model, const Joint& joint) {
  const Body& base = model.bodies[static_cast<std::size_t>(joint.base)];
  const Body& follower = model.bodies[static_cast<std::size_t>(joint.follower)];
  const Vector3d w_base = base.q_WB * base.w_WB_B, w_follower = follower.q_WB * follower.w_WB_B;
  const Vector3d r_base = base.q_WB * joint.point_base, r_follower = follower.q_WB * joint.point_follower;
  const Vector3d swing = w_follower.cross(w_follower.cross(r_follower)) - w_base.cross(w_base.cross(r_base));

  KktHinge out;
  out.base = joint.base;
  out.follower = joint.follower;
  for (int r = 0; r < kKktRows; ++r) {
    const Vector3d n = base.q_WB * joint.axes.col(r % 3);
    double* of_base = out.base_rows + 6 * r;
    double* of_follower = out.follower_rows + 6 * r;
    const bool point = r < 3;
    Vector3d::Map(of_follower) = point ? n : Vector3d::Zero();
    Vector3d::Map(of_follower + 3) = point ? r_follower.cross(n) : n;
    Vector3d::Map(of_base) = point ? Vector3d(-n) : Vector3d::Zero();
    Vector3d::Map(of_base + 3) = point ? Vector3d(-r_base.cross(n)) : Vector3d(-n);
    out.bias[r] = point ? -n.dot(swing) : -w_base.cross(n).dot(w_follower - w_base);
  }
  return out;
}

KktSystem build_kkt(const Model& model) {
  KktSystem system;
  for (const Body& body : model.bodies) system.bodies.push_back(calc_body(body, model.gravity.uniform));
  for (const Joint& joint : model.joints) system.hinges.push_back(calc_hinge(model, joint));
  return system;
}

class Kkt final : public Solver {
 public:
  Kkt(const Model& model, std::unique_ptr<KktSolver> solver) : model_(model), solver_(std::move(solver)) {}

  void solve() override { solver_->solve(); }

  Solution build_solution() const override {
    std::vector<double> bodies;
    Solution solution;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const double* a = solver_->get_acceleration(static_cast<int>(b));
      bodies.insert(bodies.end(), a, a + 6);
    }
    solution.accelerations = calc_coordinates(model_, bodies);
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const double* lambda = solver_->get_multipliers(static_cast<int>(j));
      solution.multipliers.insert(solution.multipliers.end(), lambda, lambda + kHingeRows);
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
