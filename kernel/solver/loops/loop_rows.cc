#include "kernel/solver/loops/loop_rows.h"

#include "kernel/joints/kinematics.h"
#include "kernel/tree/loop_storage.h"

namespace unlatch {
namespace {

LoopRow build_row(const PlanData& plan, const JointFrame& f, int loop, int row) {
  const std::int32_t joint = plan.loops[at(loop)];
  const PlanJoint& j = plan.joints[at(joint)];
  return {loop,
          joint,
          j.non_tree,
          row,
          j.base,
          j.follower,
          kNone,
          calc_row_wrench(f, row, false),
          calc_row_wrench(f, row, true),
          {}};
}

// The row's relative acceleration, in the latest solution.
double apply_row(const LoopRow& row, const Evaluation& ev) {
  const double follower = dot(row.on_follower, ev.get_acceleration(row.follower));
  return row.base == kGround ? follower : follower + dot(row.on_base, ev.get_acceleration(row.base));
}

// τᵀ J⁻¹ τ
double calc_turning_mobility(const Sym3& J, const Vec3& torque) {
  const Vec3 x{J.xx, J.xy, J.xz}, y{J.xy, J.yy, J.yz}, z{J.xz, J.yz, J.zz};
  const Vec3 yz = cross(y, z);
  return dot(torque, Mat3{yz, cross(z, x), cross(x, y)} * torque) / dot(x, yz);
}

// The same for a force as well, at the body's origin; a marker has the mobility of its body.
double calc_mobility(const PlanData& plan, const Evaluation& ev, int body, Spatial w) {
  const PlanBody& b = plan.bodies[at(body)];
  double mass = b.mass;
  if (b.varying != kNone) mass = ev.varying[at(b.varying)].mass;
  if (b.flexible != kNone) {
    const PlanFlexible& carrier = plan.flexible[at(b.flexible)];
    w.ang += cross(get_body_frame(ev, body).p - get_body_frame(ev, carrier.body).p, w.lin);
    mass = carrier.mass;
    body = carrier.body;
  }
  const Sym3 inertia = read(ev.blocks.data(), ev.places[at(body)], &SharedBlock<double>::inertia);
  return dot(w.lin, w.lin) / mass + calc_turning_mobility(inertia, w.ang);
}

// Mobility of a row's two bodies along it if nothing held them.
double calc_free_mobility(const PlanData& plan, const Evaluation& ev, const LoopRow& row) {
  const double follower = calc_mobility(plan, ev, row.follower, row.on_follower);
  return row.base == kGround ? follower : calc_mobility(plan, ev, row.base, row.on_base) + follower;
}
double calc_free_mobility(const PlanData& plan, const Evaluation& ev, const LoopClosure& closure, int row) {
  const PlanJoint& joint = plan.joints[at(closure.joint)];
  const JointFrame& f = ev.non_tree_frames[at(closure.non_tree)];
  const double follower = calc_mobility(plan, ev, joint.follower, calc_row_wrench(f, row, true));
  return joint.base == kGround ? follower
                               : calc_mobility(plan, ev, joint.base, calc_row_wrench(f, row, false)) + follower;
}

// What a row's relative acceleration is to be.
double calc_row_target(const Evaluation& ev, std::int32_t non_tree, int row) {
  const JointFrame& f = ev.non_tree_frames[at(non_tree)];
  const Spatial& bias = ev.non_tree_bias[at(non_tree)];
  return row < kRotX ? dot(column(f.n, row), bias.lin) : dot(column(f.m, row - kRotX), bias.ang);
}

void take_all_rows(const PlanData& plan, const State& state, const LoopClosure& closure, const Evaluation& ev,
                   ClosureWork& c) {
  const RowSet rows = get_active_rows(plan, state, closure.joint);
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(rows, r)) continue;
    c.free[c.count] = calc_free_mobility(plan, ev, closure, r);
    c.row[c.count++] = r;
  }
}

void take_kept_rows(ClosureWork& c) {
  c.count = c.start_rank;
  for (int k = 0; k < c.count; ++k) {
    c.row[k] = c.start_row[k];
    c.free[k] = c.start_free[k];
  }
}

}  // namespace

void update_loop_rows(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  ev.loop_count = ev.loop_redundant = 0;
  for (std::size_t l = 0; l < plan.loops.size(); ++l) {
    const std::int32_t joint = plan.loops[l];
    ev.loop_ranges[l] = ev.loop_count;
    for (int r = 0; r < kRows; ++r)
      if (has_row(get_active_rows(plan, state, joint), r))
        ev.loop_rows[at(ev.loop_count++)] =
            build_row(plan, ev.non_tree_frames[at(plan.joints[at(joint)].non_tree)], static_cast<int>(l), r);
  }
  ev.loop_ranges[plan.loops.size()] = ev.loop_count;
}

void begin_clusters(const PlanData& plan, const State& state, LoopRows rows, Evaluation& ev) noexcept {
  ev.loop_count = ev.loop_redundant = 0;
  for (std::size_t e = 0; e < plan.closures.size(); ++e) {
    ClosureWork& c = ev.closures[e];
    c.count = c.rank = 0;
    if (rows == LoopRows::kKept)
      take_kept_rows(c);
    else
      take_all_rows(plan, state, plan.closures[e], ev, c);
    c.most = rows == LoopRows::kAll ? kRows : c.start_rank;
    for (int k = 0; k < kRows; ++k) c.order[k] = k;
    ev.loop_count += c.count;
  }
}

void keep_cluster_rows(Evaluation& ev) noexcept {
  for (ClosureWork& c : ev.closures) {
    c.start_rank = c.rank;
    for (int k = 0; k < c.rank; ++k) {
      c.start_row[k] = c.row[c.order[k]];
      c.start_free[k] = c.free[c.order[k]];
    }
  }
}

void count_redundant_rows(Evaluation& ev) noexcept {
  ev.loop_redundant = 0;
  for (const ClosureWork& c : ev.closures) ev.loop_redundant += c.count - c.rank;
}

std::int32_t count_nearly_redundant_rows(const PlanData& plan, const Evaluation& ev, std::size_t closure) noexcept {
  const ClosureWork& c = ev.closures[closure];
  const double* block = find_loop_block(ev.cluster_matrix, plan.closures[closure].block);
  std::int32_t count = 0;
  for (int k = c.rank; k < c.count; ++k)
    count += is_nearly_redundant(c.get_entry(c.order[k]), get_diagonal(block, c.order[k])) ? 1 : 0;
  return count;
}

void begin_cluster_targets(const PlanData& plan, Evaluation& ev, bool biased) noexcept {
  for (std::size_t e = 0; e < plan.closures.size(); ++e) {
    ClosureWork& c = ev.closures[e];
    for (int k = 0; k < kEight; ++k) c.target[k] = c.mu[k] = 0;
    for (int k = 0; biased && k < c.count; ++k) c.target[k] = calc_row_target(ev, plan.closures[e].non_tree, c.row[k]);
  }
}

void begin_pivots(const PlanData& plan, Evaluation& ev) noexcept {
  for (int r = 0; r < ev.loop_count; ++r) {
    LoopRow& row = ev.loop_rows[at(r)];
    row.pivot = r;
    row.entry = {get_loop_matrix(plan, ev)(r, r), 0, calc_free_mobility(plan, ev, row)};
  }
}

int find_pivot(const PlanData& plan, const Evaluation& ev, int first) noexcept {
  int best = kNone;
  double largest = 0;
  for (int r = first; r < ev.loop_count; ++r) {
    const RowEntry& entry = get_pivot_row(ev, r).entry;
    const double pivot = get_loop_matrix(plan, ev)(r, r);
    if (pivot > largest * entry.own && is_independent(entry, pivot)) {
      largest = pivot / entry.own;
      best = r;
    }
  }
  return best;
}

void take_pivot(const PlanData& plan, Evaluation& ev, int rank, int r) noexcept {
  if (r != rank) std::swap(ev.loop_rows[at(rank)].pivot, ev.loop_rows[at(r)].pivot);
  interchange(get_loop_matrix(plan, ev), ev.loop_count, rank, r);
}

void solve_loop_rows(const PlanData& plan, Evaluation& ev, bool biased) noexcept {
  for (int r = 0; r < ev.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ev, r);
    ev.loop_solution[at(r)] = (biased ? calc_row_target(ev, row.non_tree, row.row) : 0) - apply_row(row, ev);
  }
  const int rank = ev.loop_count - ev.loop_redundant;
  solve_ldl(get_loop_matrix(plan, ev), rank, ev.loop_solution.data());
  for (int r = rank; r < ev.loop_count; ++r) ev.loop_solution[at(r)] = 0;
}

void clear_loop_multipliers(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanNonTreeJoint& joint : plan.non_tree_joints)
    for (std::size_t r = 0; r < kRows; ++r) ev.multipliers.get(at(joint.joint), r) = 0;
}

void store_loop_multipliers(Evaluation& ev) noexcept {
  for (int r = 0; r < ev.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ev, r);
    ev.multipliers.get(at(row.joint), at(row.row)) = ev.loop_solution[at(r)];
  }
}

LoopReactions::LoopReactions(const PlanData& plan, Evaluation& ev, Source source) noexcept : ev_(ev), source_(source) {
  double* blocks = ev.blocks.data();
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const LaneOf<SharedLane> lane = get_lane<SharedLane>(blocks, ev.places[b]);
    ev.loop_forces[b] = lane.read(&SharedLane::force);
    if (source == Source::kNothing) lane.write(&SharedLane::force, {{0, 0, 0}, {0, 0, 0}});
  }
  const auto push = [&](int body, double size, const Spatial& wrench) {
    if (body != kGround) add(blocks, ev.places[at(body)], &SharedLane::force, size * wrench);
  };
  for (int r = 0; r < ev.loop_count; ++r) {
    const LoopRow& row = get_pivot_row(ev, r);
    push(row.follower, ev.loop_solution[at(r)], row.on_follower);
    push(row.base, ev.loop_solution[at(r)], row.on_base);
  }
}

LoopReactions::~LoopReactions() {
  for (std::size_t b = 0; b < ev_.loop_forces.size(); ++b)
    write(ev_.blocks.data(), ev_.places[b], &SharedLane::force, ev_.loop_forces[b]);
}

}  // namespace unlatch
