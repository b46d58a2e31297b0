#include "tests/support/scalar_solver.h"

#include <bit>
#include <stdexcept>

#include "kernel/joints/kinematics.h"
#include "tests/support/linear_algebra.h"

namespace unlatch::test {
namespace {

using Rows = Eigen::Matrix<double, 6, Eigen::Dynamic>;  // a column for each row that holds

Eigen::Vector3d to_eigen(const Vec3& a) { return {a.x, a.y, a.z}; }
Vector6 stack(const Eigen::Vector3d& lin, const Eigen::Vector3d& ang) {
  Vector6 out;
  out << lin, ang;
  return out;
}
Vector6 to_eigen(const Spatial& a) { return stack(to_eigen(a.lin), to_eigen(a.ang)); }
Eigen::Matrix3d to_eigen(const Sym3& J) {
  Eigen::Matrix3d out;
  out << J.xx, J.xy, J.xz, J.xy, J.yy, J.yz, J.xz, J.yz, J.zz;
  return out;
}

// A freedom of a joint, and what its elimination leaves behind for the way down.
struct Freedom {
  Vector6 s, U;
  double d;
};

// A body, and its joint to the parent.
struct Body {
  int parent = kNone, joint = kNone;  // parent: node
  double side = 0;                    // +1: it is the joint's follower; −1: its base
  std::vector<int> row_names;         // Row of each row that holds
  Rows W{6, 0};                       // their unit wrenches on the body, at its origin
  Vector6 bias = Vector6::Zero();     // c
  Matrix6d X = Matrix6d::Identity();  // motion of the parent → motion of this body
  Matrix6d own = Matrix6d::Zero();    // its own inertia
  bool by_freedoms = false;
  std::vector<Freedom> freedoms;  // in the order of their elimination
  Matrix6d A;
  Matrix6d inverse;             // of A, where it is eliminated before its rows
  Eigen::MatrixXd row_inverse;  // Λ⁻¹ of its rows
};

class Tree {
 public:
  Tree(const PlanData& plan, const State& state, const Evaluation& ev) : bodies_(plan.nodes.size()) {
    for (std::size_t k = 0; k < bodies_.size(); ++k) read_body(plan, state, ev, plan.nodes[k], bodies_[k]);
    factor();
  }

  // `loads`: per node. Without `biased` the rows prescribe no acceleration. Accelerations are per node.
  ScalarSolution solve(std::vector<Vector6> loads, bool biased, std::size_t joints) const {
    const std::size_t n = bodies_.size();
    std::vector<std::vector<double>> beta(n);
    for (std::size_t k = n; k-- > 0;) {  // from the leaves to the root
      const Body& body = bodies_[k];
      const Vector6 c = biased ? body.bias : Vector6::Zero();
      Vector6 passed = Vector6::Zero();
      if (body.by_freedoms) {
        passed = loads[k] - body.A * c;
        for (const Freedom& f : body.freedoms) {
          beta[k].push_back(f.s.dot(passed));
          passed -= f.U * beta[k].back() / f.d;
        }
      } else if (body.W.cols() > 0) {
        passed = body.W * (body.row_inverse * (body.W.transpose() * (body.inverse * loads[k] - c)));
      }
      if (body.parent != kNone) loads[at(body.parent)] += body.X.transpose() * passed;
    }
    ScalarSolution out{std::vector<Vector6>(n, Vector6::Zero()), std::vector<Vector6>(joints, Vector6::Zero())};
    for (std::size_t k = 0; k < n; ++k) {  // from the root to the leaves
      const Body& body = bodies_[k];
      const Vector6 c = biased ? body.bias : Vector6::Zero();
      Vector6 a = Vector6::Zero();
      if (body.parent != kNone) a = body.X * out.accelerations[at(body.parent)];
      if (body.by_freedoms) {
        for (std::size_t f = body.freedoms.size(); f-- > 0;) {
          const Freedom& freedom = body.freedoms[f];
          a += freedom.s * ((beta[k][f] - freedom.U.dot(a)) / freedom.d);
        }
        a += c;
      } else {
        const Vector6 free = body.inverse * loads[k];
        Vector6 push = Vector6::Zero();
        if (body.W.cols() > 0) push = body.W * (body.row_inverse * (body.W.transpose() * (a + c - free)));
        a = free + body.inverse * push;
      }
      out.accelerations[k] = a;
      if (body.joint != kNone) out.multipliers[at(body.joint)] = find_multipliers(body, body.A * a - loads[k]);
    }
    return out;
  }

 private:
  static void read_body(const PlanData& plan, const State& state, const Evaluation& ev, const TreeNode& node,
                        Body& out) {
    const Place& place = plan.places[at(node.body)];
    const double* blocks = ev.blocks.data();
    out.parent = node.parent;
    out.joint = node.joint;
    out.side = node.side;
    out.own.topLeftCorner<3, 3>() = plan.bodies[at(node.body)].mass * Eigen::Matrix3d::Identity();
    out.own.bottomRightCorner<3, 3>() = to_eigen(read(blocks, place, &SharedLane::inertia));
    if (node.joint == kNone) return;
    const Eigen::Vector3d arm = to_eigen(read(blocks, place, &SolverLane::arm_child));
    const Eigen::Vector3d offset = to_eigen(read(blocks, place, &SolverLane::offset));
    for (int i = 0; i < 3; ++i) out.X.block<3, 1>(0, 3 + i) = Eigen::Vector3d::Unit(i).cross(offset);  // α × r
    out.bias = to_eigen(read(blocks, place, &SolverLane::bias));
    const RowSet rows = get_active_rows(plan, state, node.joint);
    out.by_freedoms = std::popcount(static_cast<unsigned>(rows)) >= 3;
    const JointView view(plan, ev, node.joint);
    for (int r = 0; r < kRows; ++r) {
      const Eigen::Vector3d axis = to_eigen(view.get_axis(r)), none = Eigen::Vector3d::Zero();
      if (has_row(rows, r)) {
        out.row_names.push_back(r);
        out.W.conservativeResize(6, out.W.cols() + 1);
        out.W.rightCols<1>() = r < kRotX ? stack(axis, arm.cross(axis)) : stack(none, axis);
      } else if (out.by_freedoms) {
        out.freedoms.push_back({r < kRotX ? stack(axis, none) : stack(arm.cross(axis), axis), Vector6::Zero(), 0});
      }
    }
  }

  void factor() {
    for (Body& body : bodies_) body.A = body.own;
    for (std::size_t k = bodies_.size(); k-- > 0;) {
      Body& body = bodies_[k];
      Matrix6d passed = Matrix6d::Zero();
      if (body.by_freedoms) {
        passed = body.A;
        for (Freedom& f : body.freedoms) {
          f.U = passed * f.s;
          f.d = f.s.dot(f.U);
          passed -= f.U * f.U.transpose() / f.d;
        }
      } else {
        body.inverse = calc_inverse(body.A);
        if (body.W.cols() > 0) {
          body.row_inverse =
              calc_inverse(Eigen::MatrixXd(body.W.transpose().lazyProduct(body.inverse)).lazyProduct(body.W));
          passed = Rows(body.W.lazyProduct(body.row_inverse)).lazyProduct(body.W.transpose());
        }
      }
      if (body.parent != kNone) bodies_[at(body.parent)].A += body.X.transpose() * passed * body.X;
    }
  }

  // Components of the joint's wrench on the child along its rows, with the sign of the follower.
  static Vector6 find_multipliers(const Body& body, const Vector6& wrench) {
    Vector6 out = Vector6::Zero();
    if (body.row_names.empty()) return out;
    const Eigen::VectorXd sizes = solve_least_squares(body.W, wrench);
    for (std::size_t i = 0; i < body.row_names.size(); ++i)
      out[body.row_names[i]] = body.side * sizes[static_cast<Eigen::Index>(i)];
    return out;
  }

  std::vector<Body> bodies_;  // in the order of PlanData::nodes: parents before children
};

// A row of a joint that closes a loop: its unit wrenches on all bodies, and what it prescribes.
struct LoopRow {
  int joint, row;
  std::vector<Vector6> wrenches;  // per node
  double target;

  double apply(const ScalarSolution& solution) const {
    double sum = 0;
    for (std::size_t k = 0; k < wrenches.size(); ++k) sum += wrenches[k].dot(solution.accelerations[k]);
    return sum;
  }
};

std::vector<LoopRow> list_loop_rows(const PlanData& plan, const State& state, const Evaluation& ev) {
  std::vector<std::size_t> node_of(plan.bodies.size());
  for (std::size_t k = 0; k < plan.nodes.size(); ++k) node_of[at(plan.nodes[k].body)] = k;
  std::vector<LoopRow> out;
  for (const std::int32_t j : plan.loops) {
    const PlanJoint& joint = plan.joints[at(j)];
    const JointFrame& f = ev.non_tree_frames[at(joint.non_tree)];
    const Spatial& bias = ev.non_tree_bias[at(joint.non_tree)];
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(get_active_rows(plan, state, j), r)) continue;
      const Vec3 axis = r < kRotX ? column(f.n, r) : column(f.m, r - kRotX);
      LoopRow row{j, r, std::vector<Vector6>(plan.nodes.size(), Vector6::Zero()),
                  dot(axis, r < kRotX ? bias.lin : bias.ang)};
      const auto push = [&](int body, double sign, const Vec3& arm) {
        if (body == kGround) return;
        const Vec3 none{0, 0, 0};
        row.wrenches[node_of[at(body)]] =
            sign * to_eigen(r < kRotX ? Spatial{axis, cross(arm, axis)} : Spatial{none, axis});
      };
      push(joint.follower, 1, f.r_follower);
      push(joint.base, -1, f.r_base);
      out.push_back(row);
    }
  }
  return out;
}

void add(ScalarSolution& to, double size, const ScalarSolution& other) {
  for (std::size_t i = 0; i < to.accelerations.size(); ++i) to.accelerations[i] += size * other.accelerations[i];
  for (std::size_t i = 0; i < to.multipliers.size(); ++i) to.multipliers[i] += size * other.multipliers[i];
}

void add_loops(const Tree& tree, const std::vector<LoopRow>& rows, ScalarSolution& solution) {
  const auto count = static_cast<Eigen::Index>(rows.size());
  std::vector<ScalarSolution> replies;  // a_w
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd missing(count);
  for (const LoopRow& row : rows) replies.push_back(tree.solve(row.wrenches, false, solution.multipliers.size()));
  for (Eigen::Index r = 0; r < count; ++r) {
    missing[r] = rows[at(static_cast<int>(r))].target - rows[at(static_cast<int>(r))].apply(solution);
    for (Eigen::Index s = 0; s < count; ++s)
      matrix(r, s) = rows[at(static_cast<int>(r))].apply(replies[at(static_cast<int>(s))]);
  }
  const Eigen::VectorXd mu = solve_full_pivots(matrix, missing);
  for (Eigen::Index r = 0; r < count; ++r) {
    const LoopRow& row = rows[at(static_cast<int>(r))];
    add(solution, mu[r], replies[at(static_cast<int>(r))]);
    solution.multipliers[at(row.joint)][row.row] = mu[r];
  }
}

}  // namespace

ScalarSolution solve_one_by_one(const PlanData& plan, const State& state, const Evaluation& ev) {
  if (!plan.rigid || !plan.compliant.empty())
    throw std::invalid_argument("scalar solver: a flexible body, a mass law or an implicit spring");
  const Tree tree(plan, state, ev);
  std::vector<Vector6> loads;
  for (const TreeNode& node : plan.nodes)
    loads.push_back(to_eigen(read(ev.blocks.data(), plan.places[at(node.body)], &SharedLane::force)));
  ScalarSolution solution = tree.solve(loads, true, plan.joints.size());
  const std::vector<LoopRow> rows = list_loop_rows(plan, state, ev);
  if (!rows.empty()) add_loops(tree, rows, solution);
  std::vector<Vector6> by_body(plan.bodies.size());
  for (std::size_t k = 0; k < plan.nodes.size(); ++k) by_body[at(plan.nodes[k].body)] = solution.accelerations[k];
  solution.accelerations = by_body;
  return solution;
}

}  // namespace unlatch::test
