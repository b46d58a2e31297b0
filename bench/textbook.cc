// Block elimination as in the textbook: Baraff 1996 (CMU-RI-TR-95-44), with bodies (6×6) and hinges (5×5) as the nodes
// of one tree, each of which has a single neighbour, its parent, that is eliminated after it:
//   factor  D_i = H_ii − Σ H_ci^T D_c⁻¹ H_ci,   W_i = D_i⁻¹ H_ip      leaves to root
//   solve   y_p −= W_i^T y_i leaves to root;  x_i = D_i⁻¹ y_i − W_i x_p root to leaves
// A body's D is positive definite, a hinge's negative definite: −D is factored. Nothing is allocated per call.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/StdVector>

#include "bench/kkt.h"

namespace unlatch::bench {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix5 = Eigen::Matrix<double, kKktRows, kKktRows>;
using Vector5 = Eigen::Matrix<double, kKktRows, 1>;
using Rows = Eigen::Matrix<double, kKktRows, 6>;
using RowsMap = Eigen::Map<const Eigen::Matrix<double, kKktRows, 6, Eigen::RowMajor>>;

// A body and the hinge to its parent; the root's hinge is not used.
struct Node {
  int parent;
  // given
  Matrix6 M;
  Rows G, G_parent;
  Vector6 F;
  Vector5 c;
  // computed
  Matrix6 D;                             // of the body
  Eigen::LLT<Matrix6> body;              // D
  Eigen::LLT<Matrix5> hinge;             // G D⁻¹ Gᵀ
  Eigen::Matrix<double, 6, kKktRows> W;  // D⁻¹ Gᵀ
  Rows V;                                // (G D⁻¹ Gᵀ)⁻¹ G_parent
  Vector6 y, a;
  Vector5 z, lambda;
};

class Textbook final : public KktSolver {
 public:
  explicit Textbook(const KktSystem& system) : nodes_(system.bodies.size()) {
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const KktBody& body = system.bodies[k];
      Node& node = nodes_[k];
      node.M.setZero();
      node.M.topLeftCorner<3, 3>().diagonal().setConstant(body.mass);
      node.M.bottomRightCorner<3, 3>() = Eigen::Map<const Eigen::Matrix3d>(body.inertia);
      node.F = Eigen::Map<const Vector6>(body.force);
      node.parent = -1;
      if (k == 0) continue;
      const KktHinge& hinge = system.hinges[k - 1];
      node.parent = hinge.base;
      node.G = RowsMap(hinge.follower_rows);
      node.G_parent = RowsMap(hinge.base_rows);
      node.c = Eigen::Map<const Vector5>(hinge.bias);
    }
  }

  void solve() override {
    factor();
    reduce();
    back_substitute();
  }

  const double* get_acceleration(int body) const override { return nodes_[static_cast<std::size_t>(body)].a.data(); }
  const double* get_multipliers(int hinge) const override {
    return nodes_[static_cast<std::size_t>(hinge) + 1].lambda.data();
  }

 private:
  Node& get_parent(const Node& node) { return nodes_[static_cast<std::size_t>(node.parent)]; }

  void factor() {
    for (Node& node : nodes_) node.D = node.M;
    for (std::size_t k = nodes_.size(); k-- > 0;) {
      Node& node = nodes_[k];
      node.body.compute(node.D);
      if (k == 0) break;
      node.W = node.G.transpose();
      node.body.solveInPlace(node.W);
      node.hinge.compute(node.G * node.W);
      node.V = node.G_parent;
      node.hinge.solveInPlace(node.V);
      get_parent(node).D.noalias() += node.G_parent.transpose() * node.V;
    }
  }

  // Right-hand sides: F of the bodies, −c of the hinges.
  void reduce() {
    for (Node& node : nodes_) node.y = node.F;
    for (std::size_t k = nodes_.size(); k-- > 1;) {
      Node& node = nodes_[k];
      node.z.noalias() = node.W.transpose() * node.y - node.c;
      get_parent(node).y.noalias() -= node.V.transpose() * node.z;
    }
  }

  void back_substitute() {
    nodes_[0].a = nodes_[0].body.solve(nodes_[0].y);
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      Node& node = nodes_[k];
      node.lambda = -node.hinge.solve(node.z);
      node.lambda.noalias() -= node.V * get_parent(node).a;
      node.a = node.body.solve(node.y);
      node.a.noalias() += node.W * node.lambda;
    }
  }

  std::vector<Node, Eigen::aligned_allocator<Node>> nodes_;
};

}  // namespace

std::unique_ptr<KktSolver> build_textbook_solver(const KktSystem& system) { return std::make_unique<Textbook>(system); }

}  // namespace unlatch::bench
