// Block elimination of the textbook: Baraff 1996 (CMU-RI-TR-95-44), with bodies (6×6) and joints (m×m, m their rows) as
// the nodes of one tree, each of which has a single neighbour, its parent, that is eliminated after it:
//   factor  D_i = H_ii − Σ H_ci^T D_c⁻¹ H_ci,   W_i = D_i⁻¹ H_ip      leaves to root
//   solve   y_p −= W_i^T y_i leaves to root;  x_i = D_i⁻¹ y_i − W_i x_p root to leaves
// A body's D is positive definite, a joint's negative definite: −D is factored. Every number of rows has its own code
// with Eigen's fixed sizes. Nothing is allocated per call.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "bench/kkt.h"

namespace unlatch::bench {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

template <int kRows>
struct JointBlock {
  using Square = Eigen::Matrix<double, kRows, kRows>;
  using Vector = Eigen::Matrix<double, kRows, 1>;
  using Rows = Eigen::Matrix<double, kRows, 6>;
  // Input.
  Rows G, G_parent;
  Vector c;
  // Results.
  Eigen::LLT<Square> S;               // G D⁻¹ Gᵀ, D of the body
  Eigen::Matrix<double, 6, kRows> W;  // D⁻¹ Gᵀ
  Rows V;                             // S⁻¹ G_parent
  Vector z, lambda;
};

// A body and where its joint to the parent is; the root has none.
struct Node {
  int parent = -1, rows = 0;
  std::size_t joint = 0;  // index among the joints of as many rows
  // Input.
  Matrix6 M;
  Vector6 F;
  // Results.
  Matrix6 D;                 // of the body
  Eigen::LLT<Matrix6> body;  // D
  Vector6 y, a;
};

template <int kRows>
JointBlock<kRows> build_joint(const KktJoint& joint) {
  JointBlock<kRows> block;
  for (int r = 0; r < kRows; ++r) {
    block.G.row(r) = Vector6::Map(joint.follower_rows + 6 * r).transpose();
    block.G_parent.row(r) = Vector6::Map(joint.base_rows + 6 * r).transpose();
    block.c(r) = joint.bias[r];
  }
  return block;
}

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
      if (k > 0) attach(node, system.joints.at(k - 1), static_cast<int>(k));
    }
    if (system.joints.size() + 1 != nodes_.size()) throw std::invalid_argument("textbook: not a tree with a free root");
  }

  void solve() override {
    factor();
    reduce();
    back_substitute();
  }

  const double* get_acceleration(int body) const override { return nodes_[static_cast<std::size_t>(body)].a.data(); }
  const double* get_multipliers(int joint) const override {
    const double* lambda = nullptr;
    auto* self = const_cast<Textbook*>(this);
    self->visit(self->nodes_[static_cast<std::size_t>(joint) + 1], [&](auto& block) { lambda = block.lambda.data(); });
    return lambda;
  }

 private:
  template <int kRows>
  std::vector<JointBlock<kRows>>& get_joints() {
    return std::get<kRows - 1>(joints_);
  }

  void attach(Node& node, const KktJoint& joint, int body) {
    if (joint.follower != body || joint.base < 0 || joint.base >= body)
      throw std::invalid_argument("textbook: joints out of order");
    node.parent = joint.base;
    node.rows = joint.count;
    const auto add = [&]<int kRows>(std::vector<JointBlock<kRows>>& blocks) {
      if (kRows != joint.count) return;
      node.joint = blocks.size();
      blocks.push_back(build_joint<kRows>(joint));
    };
    std::apply([&](auto&... blocks) { (add(blocks), ...); }, joints_);
  }

  // Calls f with the node's joint, in separate code for each number of rows.
  template <class F>
  void visit(const Node& node, F&& f) {
    switch (node.rows) {
      case 1:
        return f(get_joints<1>()[node.joint]);
      case 2:
        return f(get_joints<2>()[node.joint]);
      case 3:
        return f(get_joints<3>()[node.joint]);
      case 4:
        return f(get_joints<4>()[node.joint]);
      case 5:
        return f(get_joints<5>()[node.joint]);
      case 6:
        return f(get_joints<6>()[node.joint]);
    }
  }
  Node& get_parent(const Node& node) { return nodes_[static_cast<std::size_t>(node.parent)]; }

  void factor() {
    for (Node& node : nodes_) node.D = node.M;
    for (std::size_t k = nodes_.size(); k-- > 0;) {
      Node& node = nodes_[k];
      node.body.compute(node.D);
      if (k == 0) break;
      visit(node, [&](auto& joint) {
        joint.W = joint.G.transpose();
        node.body.solveInPlace(joint.W);
        joint.S.compute(joint.G * joint.W);
        joint.V = joint.G_parent;
        joint.S.solveInPlace(joint.V);
        get_parent(node).D.noalias() += joint.G_parent.transpose() * joint.V;
      });
    }
  }

  // Right-hand sides: F of the bodies, −c of the joints.
  void reduce() {
    for (Node& node : nodes_) node.y = node.F;
    for (std::size_t k = nodes_.size(); k-- > 1;) {
      Node& node = nodes_[k];
      visit(node, [&](auto& joint) {
        joint.z.noalias() = joint.W.transpose() * node.y - joint.c;
        get_parent(node).y.noalias() -= joint.V.transpose() * joint.z;
      });
    }
  }

  void back_substitute() {
    nodes_[0].a = nodes_[0].body.solve(nodes_[0].y);
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      Node& node = nodes_[k];
      visit(node, [&](auto& joint) {
        joint.lambda = -joint.S.solve(joint.z);
        joint.lambda.noalias() -= joint.V * get_parent(node).a;
        node.a = node.body.solve(node.y);
        node.a.noalias() += joint.W * joint.lambda;
      });
    }
  }

  std::vector<Node> nodes_;
  std::tuple<std::vector<JointBlock<1>>, std::vector<JointBlock<2>>, std::vector<JointBlock<3>>,
             std::vector<JointBlock<4>>, std::vector<JointBlock<5>>, std::vector<JointBlock<6>>>
      joints_;
};

}  // namespace

std::unique_ptr<KktSolver> build_textbook_solver(const KktSystem& system) { return std::make_unique<Textbook>(system); }

}  // namespace unlatch::bench
