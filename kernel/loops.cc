#include "kernel/loops.h"

#include "kernel/kinematics.h"
#include "kernel/lane_access.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A pivot this small beside the row's own diagonal entry: the row follows from those before it.
constexpr double kRedundant = 1e-10;

double& entry(Workspace& ws, int row, int column) { return ws.loop_matrix[at(row) * ws.loop_rows.size() + at(column)]; }

// What row `row` of a joint does with unit multiplier: a wrench at each body's origin.
LoopRow build_row(const Plan& plan, const JointFrame& f, int joint, int row) {
  const PlanJoint& j = plan.joints[at(joint)];
  LoopRow out{joint, j.loose, row, j.base, j.follower, {}, {}, false};
  if (row < kRotX) {
    const Vec3& n = column(f.n, row);
    out.on_follower = {n, cross(f.r_follower, n)};
    out.on_base = {-n, -cross(f.r_base, n)};
  } else {
    const Vec3& m = column(f.m, row - kRotX);
    out.on_follower = {{0, 0, 0}, m};
    out.on_base = {{0, 0, 0}, -m};
  }
  return out;
}

// The row's relative acceleration, in the latest solution.
double apply_row(const LoopRow& row, const Workspace& ws) {
  const double follower = dot(row.on_follower, ws.accelerations[at(row.follower)]);
  return row.base == kGround ? follower : follower + dot(row.on_base, ws.accelerations[at(row.base)]);
}

// The loads of a sweep: those of `source`, or none, in the rows of the accelerations.
void init_loads(const Plan& plan, Workspace& ws, Source source) {
  for (const LaneGroup& group : plan.groups) {
    double* loads = ws.lanes.data() + group.data + kAcceleration * group.width;
    const double* forces = ws.lanes.data() + group.data + kForce * group.width;
    for (int i = 0; i < 6 * group.width; ++i) loads[i] = source == Source::kForces ? forces[i] : 0;
  }
}

void add_wrench(const LoopRow& row, double size, Workspace& ws) {
  const auto add = [&](int body, const Spatial& wrench) {
    if (body == kGround) return;
    add_vec(ws.lanes.data(), ws.slots[at(body)], kAcceleration, size * wrench.lin);
    add_vec(ws.lanes.data(), ws.slots[at(body)], kAcceleration + 3, size * wrench.ang);
  };
  add(row.follower, row.on_follower);
  add(row.base, row.on_base);
}

void sweep_tree(const Plan& plan, Workspace& ws, const Sweep& sweep) {
  plan.kernels->reduce(plan, ws, sweep);
  plan.kernels->substitute(plan, ws, sweep);
}

// Column k of Λ: what its row's unit wrench does along all rows.
void update_column(const Plan& plan, Workspace& ws, int k) {
  init_loads(plan, ws, Source::kNothing);
  add_wrench(ws.loop_rows[at(k)], 1, ws);
  sweep_tree(plan, ws, {Source::kGiven, false, false});
  for (int r = k; r < ws.loop_count; ++r) entry(ws, r, k) = apply_row(ws.loop_rows[at(r)], ws);
}

// LDLᵀ of Λ in place, row by row: the unit lower triangle below the diagonal, the pivots on it. Redundant rows get
// none.
void factor_matrix(Workspace& ws) {
  ws.loop_redundant = 0;
  for (int r = 0; r < ws.loop_count; ++r) {
    const double own = entry(ws, r, r);
    double pivot = own;
    for (int c = 0; c < r; ++c) {
      if (!ws.loop_rows[at(c)].independent) continue;
      double sum = entry(ws, r, c);
      for (int k = 0; k < c; ++k)
        if (ws.loop_rows[at(k)].independent) sum -= entry(ws, r, k) * entry(ws, k, k) * entry(ws, c, k);
      entry(ws, r, c) = sum / entry(ws, c, c);
      pivot -= entry(ws, r, c) * sum;
    }
    entry(ws, r, r) = pivot;
    ws.loop_rows[at(r)].independent = pivot > kRedundant * own;
    ws.loop_redundant += ws.loop_rows[at(r)].independent ? 0 : 1;
  }
}

void solve_matrix(Workspace& ws) {
  for (int r = 0; r < ws.loop_count; ++r) {
    if (!ws.loop_rows[at(r)].independent) {
      ws.loop_solution[at(r)] = 0;
      continue;
    }
    for (int c = 0; c < r; ++c)
      ws.loop_solution[at(r)] -= ws.loop_rows[at(c)].independent ? entry(ws, r, c) * ws.loop_solution[at(c)] : 0;
  }
  for (int r = ws.loop_count - 1; r >= 0; --r) {
    if (!ws.loop_rows[at(r)].independent) continue;
    ws.loop_solution[at(r)] /= entry(ws, r, r);
    for (int below = r + 1; below < ws.loop_count; ++below)
      if (ws.loop_rows[at(below)].independent)
        ws.loop_solution[at(r)] -= entry(ws, below, r) * ws.loop_solution[at(below)];
  }
}

}  // namespace

void factor_loops(const Plan& plan, const State& state, Workspace& ws) noexcept {
  ws.loop_count = ws.loop_redundant = 0;
  for (const std::int32_t joint : plan.loops)
    for (int r = 0; r < kRows; ++r)
      if (has_row(get_active_rows(plan, state, joint), r))
        ws.loop_rows[at(ws.loop_count++)] = build_row(plan, get_joint_frame(plan, state, ws, joint), joint, r);
  for (int k = 0; k < ws.loop_count; ++k) update_column(plan, ws, k);
  factor_matrix(ws);
}

void solve_with_loops(const Plan& plan, Workspace& ws, const Sweep& sweep) noexcept {
  sweep_tree(plan, ws, {sweep.source, sweep.biased, sweep.multipliers && ws.loop_count == 0});
  for (const std::int32_t joint : plan.loose_joints)
    for (std::size_t r = 0; r < kRows; ++r) ws.multipliers.get(at(joint), r) = 0;
  if (ws.loop_count == 0) return;
  for (int r = 0; r < ws.loop_count; ++r) {
    const LoopRow& row = ws.loop_rows[at(r)];
    const JointFrame& f = ws.loose_frames[at(row.loose)];
    const Spatial& bias = ws.loose_bias[at(row.loose)];
    const double target =
        row.row < kRotX ? dot(column(f.n, row.row), bias.lin) : dot(column(f.m, row.row - kRotX), bias.ang);
    ws.loop_solution[at(r)] = (sweep.biased ? target : 0) - apply_row(row, ws);
  }
  solve_matrix(ws);
  init_loads(plan, ws, sweep.source);
  for (int r = 0; r < ws.loop_count; ++r) {
    const LoopRow& row = ws.loop_rows[at(r)];
    add_wrench(row, ws.loop_solution[at(r)], ws);
    ws.multipliers.get(at(row.joint), at(row.row)) = ws.loop_solution[at(r)];
  }
  sweep_tree(plan, ws, {Source::kGiven, sweep.biased, sweep.multipliers});
}

}  // namespace unlatch
