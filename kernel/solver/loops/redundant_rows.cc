#include "kernel/solver/loops/redundant_rows.h"

#include <bit>

#include "kernel/dynamics/flexible.h"
#include "kernel/joints/kinematics.h"
#include "kernel/solver/dense_ldl.h"
#include "kernel/solver/loops/loop_rows.h"

namespace unlatch {
namespace {

double get_scale(const PlanData& plan, int joint, int row) {
  const PlanJoint& j = plan.joints[at(joint)];
  return row < kRotX ? j.share : j.turning_share;
}

// Rows of loops in the order of their pivots; those of the tree's joints in loops behind the `independent_` ones.
class Split {
 public:
  Split(const PlanData& plan, const State& state, Evaluation& ev)
      : plan_(plan),
        state_(state),
        ev_(ev),
        redundant_(ev.loop_redundant),
        independent_(ev.loop_count - ev.loop_redundant),
        columns_(independent_) {}

  void run() {
    number_columns();
    for (std::size_t loop = 0; loop < plan_.loops.size(); ++loop) transfer(loop);
    for (int r = independent_; r < ev_.loop_count; ++r) relate(r);
    if (redundant_ <= columns_ ? solve_for_shares() : solve_for_yields()) store();
  }

 private:
  // The numbers of a row, one per column: get_numbers() takes its place among all rows, row() its place among the
  // pivots.
  double* get_numbers(int r) const { return ev_.split.relation.data() + static_cast<std::ptrdiff_t>(r) * columns_; }
  double* row(int r) const { return get_numbers(ev_.loop_rows[at(r)].pivot); }
  double* redundant_row(int d) const { return row(independent_ + d); }
  double& get_multiplier(const LoopRow& row) const { return ev_.multipliers.get(at(row.joint), at(row.row)); }

  template <class Run>
  void for_ring_rows(const Run& run) const {
    for (std::size_t i = 0; i < plan_.ring_joints.size(); ++i) {
      const RowSet rows = get_active_rows(plan_, state_, plan_.ring_joints[i]);
      int column = ev_.split.ring_columns[i];
      for (int r = 0; r < kRows; ++r)
        if (has_row(rows, r)) run(plan_.ring_joints[i], r, column++);
    }
  }

  // Columns, and their scales and scaled multipliers.
  void number_columns() {
    SplitScratch& s = ev_.split;
    for (int r = 0; r < independent_; ++r) {
      const LoopRow& own = get_pivot_row(ev_, r);
      s.scales[at(r)] = get_scale(plan_, own.joint, own.row);
      s.loads[at(r)] = get_multiplier(own) / s.scales[at(r)];
    }
    for (std::size_t i = 0; i < plan_.ring_joints.size(); ++i) {
      s.ring_columns[i] = columns_;
      columns_ += std::popcount(get_active_rows(plan_, state_, plan_.ring_joints[i]));
    }
    for_ring_rows([&](int joint, int r, int column) {
      s.scales[at(column)] = get_scale(plan_, joint, r);
      s.loads[at(column)] = ev_.multipliers.get(at(joint), at(r)) / s.scales[at(column)];
    });
  }

  // The unit forces of a loop's rows, as the tree's joints in the loop would carry them.
  void transfer(std::size_t loop) const {
    const int first = ev_.loop_ranges[loop], end = ev_.loop_ranges[loop + 1];
    for (int r = first; r < end; ++r)
      for (int c = 0; c < columns_; ++c) get_numbers(r)[c] = 0;
    const LoopPath& path = plan_.loop_paths[loop];
    carry(path.first, path.base_first, first, end, &LoopRow::on_follower);
    carry(path.base_first, path.end, first, end, &LoopRow::on_base);
  }

  // From a body towards the root; the wrenches are at the origin of the node that they have reached.
  void carry(int begin, int end, int first_row, int end_row, Spatial LoopRow::*wrench) const {
    Spatial wrenches[kRows];
    for (int r = first_row; r < end_row; ++r) wrenches[r - first_row] = ev_.loop_rows[at(r)].*wrench;
    for (int i = begin; i < end; ++i) {
      const PathNode& at_node = plan_.path_nodes[at(i)];
      const LoopNode& node = plan_.loop_nodes[at(at_node.loop_node)];
      if (at_node.ring_joint != kNone) resolve(at_node.ring_joint, wrenches, first_row, end_row);
      if (node.parent_loads == kNone) continue;  // a root
      const Vec3 offset = get_offset(node);
      for (int r = 0; r < end_row - first_row; ++r) wrenches[r].ang += cross(offset, wrenches[r].lin);
    }
  }

  // Along the rows of a joint of the tree, at its point.
  void resolve(int ring_joint, const Spatial* on_child, int first_row, int end_row) const {
    const std::int32_t joint = plan_.ring_joints[at(ring_joint)];
    const JointView view(plan_, ev_, joint);
    const bool follows = view.get_joint().child == view.get_joint().follower;
    const Vec3 arm = view.get_arm(follows);
    const RowSet rows = get_active_rows(plan_, state_, joint);
    int column = ev_.split.ring_columns[at(ring_joint)];
    for (int r = 0; r < kRows; ++r) {
      if (!has_row(rows, r)) continue;
      const Vec3 axis = follows ? view.get_axis(r) : -view.get_axis(r);
      const Spatial along = r < kRotX ? Spatial{axis, {0, 0, 0}} : Spatial{-cross(axis, arm), axis};
      for (int k = 0; k < end_row - first_row; ++k) get_numbers(first_row + k)[column] = dot(along, on_child[k]);
      ++column;
    }
  }

  // From the origin of the node's parent to its own.
  Vec3 get_offset(const LoopNode& node) const {
    const BodyKind kind = plan_.groups[at(node.group)].kind;
    if (kind == BodyKind::kRigid) return read(ev_.blocks.data(), node.place, &SolverLane::offset);
    const std::int32_t body = plan_.nodes[at(node.node)].body;
    const PlanFlexible& flexible = plan_.flexible[at(plan_.bodies[at(body)].flexible)];
    const bool inward = kind == BodyKind::kFlexible;
    const Vec3 arm = *get_marker(flexible, inward ? flexible.inboard : node.marker, ev_).arm;
    return inward ? -arm : arm;
  }

  // X of a redundant row, scaled.
  void relate(int r) const {
    const double scale = get_scale(plan_, get_pivot_row(ev_, r).joint, get_pivot_row(ev_, r).row);
    const LowerTriangle factor = get_loop_matrix(plan_, ev_);
    double* x = row(r);
    for (int i = 0; i < independent_; ++i) x[i] = factor(r, i);
    for (int i = independent_ - 1; i > 0; --i)
      for (int c = 0; c < i; ++c) x[c] -= x[i] * factor(i, c);
    for (int i = 0; i < independent_; ++i) {
      const double* of_row = row(i);
      for (int c = independent_; c < columns_; ++c) x[c] -= x[i] * of_row[c];
    }
    for (int c = 0; c < columns_; ++c) x[c] *= scale / ev_.split.scales[at(c)];
  }

  double dot_row(int d, const double* numbers) const {
    const double* x = redundant_row(d);
    double sum = 0;
    for (int c = 0; c < columns_; ++c) sum += x[c] * numbers[c];
    return sum;
  }

  // (I + X Xᵀ) μ = X λ
  bool solve_for_shares() const {
    const LowerTriangle matrix{ev_.split.matrix.data(), redundant_};
    double* shares = ev_.split.shares.data();
    for (int a = 0; a < redundant_; ++a) {
      for (int b = 0; b <= a; ++b) matrix(a, b) = dot_row(a, redundant_row(b));
      matrix(a, a) += 1;
      shares[a] = dot_row(a, ev_.split.loads.data());
    }
    if (!factor_ldl(matrix, redundant_)) return false;
    solve_ldl(matrix, redundant_, shares);
    return true;
  }

  // (I + Xᵀ X) y = λ: how far the independent rows yield to λ, and with them the redundant ones, μ = X y.
  bool solve_for_yields() const {
    const LowerTriangle matrix{ev_.split.matrix.data(), columns_};
    double* yields = ev_.split.unknowns.data();
    for (int a = 0; a < columns_; ++a) {
      for (int b = 0; b < a; ++b) matrix(a, b) = 0;
      matrix(a, a) = 1;
      yields[a] = ev_.split.loads[at(a)];
    }
    for (int d = 0; d < redundant_; ++d) {
      const double* x = redundant_row(d);
      for (int a = 0; a < columns_; ++a)
        for (int b = 0; b <= a; ++b) matrix(a, b) += x[a] * x[b];
    }
    if (!factor_ldl(matrix, columns_)) return false;
    solve_ldl(matrix, columns_, yields);
    for (int d = 0; d < redundant_; ++d) ev_.split.shares[at(d)] = dot_row(d, yields);
    return true;
  }

  // λ − Xᵀ μ, and μ.
  void store() const {
    SplitScratch& s = ev_.split;
    for (int c = 0; c < columns_; ++c) s.loads[at(c)] = 0;
    for (int d = 0; d < redundant_; ++d) {
      const double* x = redundant_row(d);
      for (int c = 0; c < columns_; ++c) s.loads[at(c)] += x[c] * s.shares[at(d)];
      const LoopRow& own = get_pivot_row(ev_, independent_ + d);
      get_multiplier(own) = get_scale(plan_, own.joint, own.row) * s.shares[at(d)];
    }
    for (int r = 0; r < independent_; ++r) get_multiplier(get_pivot_row(ev_, r)) -= s.scales[at(r)] * s.loads[at(r)];
    for_ring_rows([&](int joint, int r, int column) {
      ev_.multipliers.get(at(joint), at(r)) -= s.scales[at(column)] * s.loads[at(column)];
    });
  }

  const PlanData& plan_;
  const State& state_;
  Evaluation& ev_;
  int redundant_, independent_;
  int columns_;  // rows that are not redundant
};

}  // namespace

void split_dense_rows(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  Split(plan, state, ev).run();
}

}  // namespace unlatch
