#include "kernel/solver/loops.h"

#include <algorithm>
#include <utility>

#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/kinematics.h"
#include "kernel/plan/lane_access.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A pivot this small beside the row's own diagonal entry: the row follows from those before it.
constexpr double kRedundant = 1e-10;
// An entry this small beside what it would be if the bodies were free is rounding: the tree alone holds the row.
constexpr double kHeld = 1e-13;

// Of Λ or its factor; column ≤ row.
double& entry(const Plan& plan, Workspace& ws, int row, int column) {
  return ws.loop_matrix[at(row) * at(plan.loop_columns) + at(column)];
}

// The row that is eliminated as number r.
const LoopRow& get_pivot_row(const Workspace& ws, int r) { return ws.loop_rows[at(ws.loop_rows[at(r)].pivot)]; }

// What row `row` of a joint does with unit multiplier: a wrench at each body's origin.
LoopRow build_row(const Plan& plan, const JointFrame& f, int joint, int row) {
  const PlanJoint& j = plan.joints[at(joint)];
  LoopRow out{joint, j.loose, row, j.base, j.follower, kNone, {}, {}, 0, 0};
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
  for (const LaneOctet& octet : plan.octets) {
    double* loads = ws.lanes.data() + octet.shared + kAcceleration * kOctet;
    const double* forces = ws.lanes.data() + octet.shared + kForce * kOctet;
    for (int i = 0; i < 6 * kOctet; ++i) loads[i] = source == Source::kForces ? forces[i] : 0;
  }
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(plan, body, ws);
    for (int k = 0; k < body.modes; ++k) work.given[k] = source == Source::kForces ? work.force[k] : 0;
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

// τᵀ J⁻¹ τ
double calc_turning_mobility(const Sym3& J, const Vec3& torque) {
  const Vec3 x{J.xx, J.xy, J.xz}, y{J.xy, J.yy, J.yz}, z{J.xz, J.yz, J.zz};
  const Vec3 yz = cross(y, z);
  return dot(torque, Mat3{yz, cross(z, x), cross(x, y)} * torque) / dot(x, yz);
}

// The same for a force as well, at the body's origin; a marker has the mobility of its body.
double calc_mobility(const Plan& plan, const Workspace& ws, int body, Spatial w) {
  const PlanBody& b = plan.bodies[at(body)];
  double mass = b.mass;
  if (b.varying != kNone) mass = ws.varying[at(b.varying)].mass;
  if (b.flexible != kNone) {
    const PlanFlexible& carrier = plan.flexible[at(b.flexible)];
    w.ang += cross(get_body_frame(ws, body).p - get_body_frame(ws, carrier.body).p, w.lin);
    mass = carrier.mass;
    body = carrier.body;
  }
  return dot(w.lin, w.lin) / mass + calc_turning_mobility(ws.kinematics[at(body)].J, w.ang);
}

// How much the row's bodies would give way to it if nothing held them.
double calc_free_mobility(const Plan& plan, const Workspace& ws, const LoopRow& row) {
  const double follower = calc_mobility(plan, ws, row.follower, row.on_follower);
  return row.base == kGround ? follower : calc_mobility(plan, ws, row.base, row.on_base) + follower;
}

// Of the rows from `first` on, the one whose pivot is largest beside its row's own diagonal entry, ties to the earlier;
// kNone if all of them follow from the rows before.
int find_pivot(const Plan& plan, Workspace& ws, int first) {
  int best = kNone;
  double largest = kRedundant;
  for (int r = first; r < ws.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ws, r);
    const double pivot = entry(plan, ws, r, r);
    if (pivot > largest * row.own && pivot > kHeld * row.free) {
      largest = pivot / row.own;
      best = r;
    }
  }
  return best;
}

// Symmetric interchange of what is left at r with what is left at s < r, in the lower triangle.
void interchange(const Plan& plan, Workspace& ws, int s, int r) {
  if (r == s) return;
  const auto swap_entries = [&](int row, int column, int other_row, int other_column) {
    std::swap(entry(plan, ws, row, column), entry(plan, ws, other_row, other_column));
  };
  std::swap(ws.loop_rows[at(s)].pivot, ws.loop_rows[at(r)].pivot);
  swap_entries(s, s, r, r);
  for (int k = 0; k < s; ++k) swap_entries(s, k, r, k);
  for (int k = s + 1; k < r; ++k) swap_entries(k, s, r, k);
  for (int k = r + 1; k < ws.loop_count; ++k) swap_entries(k, s, k, r);
}

// LDLᵀ of Λ in place, the most independent rows first: pivots on the diagonal, the unit lower triangle below it. Rows
// that follow from the others come last and get no pivot.
void factor_matrix(const Plan& plan, Workspace& ws) {
  for (int r = 0; r < ws.loop_count; ++r) {
    LoopRow& row = ws.loop_rows[at(r)];
    row.pivot = r;
    row.own = entry(plan, ws, r, r);
    row.free = calc_free_mobility(plan, ws, row);
  }
  int rank = 0;
  for (; rank < std::min(ws.loop_count, ws.loop_most); ++rank) {
    const int best = find_pivot(plan, ws, rank);
    if (best == kNone) break;
    interchange(plan, ws, rank, best);
    plan.kernels->downdate_loops(plan, ws, rank);
  }
  ws.loop_redundant = ws.loop_count - rank;
}

// Of the right-hand side in ws.loop_solution, in the order of the pivots; 0 for redundant rows.
void solve_matrix(const Plan& plan, Workspace& ws) {
  const int rank = ws.loop_count - ws.loop_redundant;
  for (int r = 0; r < rank; ++r)
    for (int c = 0; c < r; ++c) ws.loop_solution[at(r)] -= entry(plan, ws, r, c) * ws.loop_solution[at(c)];
  for (int r = rank - 1; r >= 0; --r) {
    ws.loop_solution[at(r)] /= entry(plan, ws, r, r);
    for (int below = r + 1; below < rank; ++below)
      ws.loop_solution[at(r)] -= entry(plan, ws, below, r) * ws.loop_solution[at(below)];
  }
  for (int r = rank; r < ws.loop_count; ++r) ws.loop_solution[at(r)] = 0;
}

}  // namespace

void factor_loops(const Plan& plan, const State& state, Workspace& ws) noexcept {
  ws.loop_count = ws.loop_redundant = 0;
  for (std::size_t l = 0; l < plan.loops.size(); ++l) {
    const std::int32_t joint = plan.loops[l];
    ws.loop_ranges[l] = ws.loop_count;
    for (int r = 0; r < kRows; ++r)
      if (has_row(get_active_rows(plan, state, joint), r))
        ws.loop_rows[at(ws.loop_count++)] = build_row(plan, get_joint_frame(plan, state, ws, joint), joint, r);
  }
  ws.loop_ranges[plan.loops.size()] = ws.loop_count;
  if (ws.loop_count > 0) plan.kernels->reduce_loops(plan, ws);
  factor_matrix(plan, ws);
}

void substitute_with_loops(const Plan& plan, Workspace& ws, const Sweep& sweep) noexcept {
  plan.kernels->substitute(plan, ws, {sweep.source, sweep.biased, sweep.multipliers && ws.loop_count == 0});
  for (const PlanLooseJoint& loose : plan.loose_joints)
    for (std::size_t r = 0; r < kRows; ++r) ws.multipliers.get(at(loose.joint), r) = 0;
  if (ws.loop_count == 0) return;
  for (int r = 0; r < ws.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ws, r);
    const JointFrame& f = ws.loose_frames[at(row.loose)];
    const Spatial& bias = ws.loose_bias[at(row.loose)];
    const double target =
        row.row < kRotX ? dot(column(f.n, row.row), bias.lin) : dot(column(f.m, row.row - kRotX), bias.ang);
    ws.loop_solution[at(r)] = (sweep.biased ? target : 0) - apply_row(row, ws);
  }
  solve_matrix(plan, ws);
  init_loads(plan, ws, sweep.source);
  for (int r = 0; r < ws.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ws, r);
    add_wrench(row, ws.loop_solution[at(r)], ws);
    ws.multipliers.get(at(row.joint), at(row.row)) = ws.loop_solution[at(r)];
  }
  const Sweep whole{Source::kGiven, sweep.biased, sweep.multipliers};
  plan.kernels->reduce(plan, ws, whole);
  plan.kernels->substitute(plan, ws, whole);
}

}  // namespace unlatch
