#include "kernel/tree_solver.h"

#include "kernel/kinematics.h"
#include "kernel/loops.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A pivot this small beside what it was before the joint's other freedoms were taken out is rounding noise.
constexpr double kSingular = 1e-13;

UNLATCH_INLINE const Vec3& get_arm(const JointFrame& f, const PlanNode& node) {
  return node.side > 0 ? f.r_follower : f.r_base;
}

// Directions of the freedoms that the rows leave, at the node's body origin, into its pivots.
void update_freedoms(NodeFactor& node, const JointFrame& f, const Vec3& arm) {
  int count = 0;
  for (int r = kX; r <= kZ; ++r)
    if (!has_row(node.rows, r)) node.pivots[count++].s = {column(f.n, r), {0, 0, 0}};
  for (int r = kRotX; r <= kRotZ; ++r) {
    if (has_row(node.rows, r)) continue;
    const Vec3& axis = column(f.m, r - kRotX);
    node.pivots[count++].s = {cross(arm, axis), axis};
  }
  node.freedoms = static_cast<std::int8_t>(count);
}

// False if a pivot vanished beside the diagonal entry that it came from.
bool factor3(const Sym3& s, const Sym3& whole, Factor3T<double>& f) {
  f.i0 = 1.0 / s.xx;
  f.l10 = s.xy * f.i0;
  f.l20 = s.xz * f.i0;
  const double d1 = s.yy - f.l10 * s.xy, e = s.yz - f.l10 * s.xz;
  f.i1 = 1.0 / d1;
  f.l21 = e * f.i1;
  const double d2 = (s.zz - f.l20 * s.xz) - f.l21 * e;
  f.i2 = 1.0 / d2;
  return s.xx > kSingular * whole.xx && d1 > kSingular * whole.yy && d2 > kSingular * whole.zz;
}

bool factor_free(NodeFactor& node) {
  const Articulated& A = node.A;
  if (!factor3(A.M, A.M, node.free.M)) return false;
  const Mat3& W = node.free.W = {solve(node.free.M, A.H.x), solve(node.free.M, A.H.y), solve(node.free.M, A.H.z)};
  const Sym3 K{A.I.xx - dot(A.H.x, W.x), A.I.yy - dot(A.H.y, W.y), A.I.zz - dot(A.H.z, W.z),
               A.I.xy - dot(A.H.x, W.y), A.I.xz - dot(A.H.x, W.z), A.I.yz - dot(A.H.y, W.z)};
  return factor3(K, A.I, node.free.K);
}

// Takes the node's freedoms out of A one by one: what remains is what its parent carries. False if a pivot vanished.
// A leaf's block is diagonal before the first of them.
bool eliminate(NodeFactor& node, bool leaf, Articulated& A) {
  A = node.A;
  for (int k = 0; k < node.freedoms; ++k) {
    Pivot& pivot = node.pivots[k];
    pivot.U = leaf && k == 0 ? Spatial{A.M.xx * pivot.s.lin, A.I * pivot.s.ang} : A * pivot.s;
    const double D = dot(pivot.s, pivot.U);
    if (!(D > kSingular * calc_pivot_scale(node.A, pivot.s))) return false;
    pivot.inverse = 1.0 / D;
    downdate(A, pivot.inverse, pivot.U);
  }
  return true;
}

bool factor_node(const Plan& plan, const State& state, const PlanNode& node, NodeFactor& factor, Workspace& ws) {
  if (node.joint == kNone || (factor.rows = get_active_rows(plan, state, node.joint)) == 0) {
    factor.rows = 0;
    factor.freedoms = 0;
    return node.leaf || factor_free(factor);  // a single free body has its inertia's inverse in the plan
  }
  const JointFrame& f = ws.frames[at(node.joint)];
  update_freedoms(factor, f, get_arm(f, node));
  Articulated A;
  if (!eliminate(factor, node.leaf, A)) return false;
  factor.offset = state.bodies[at(node.body)].p;
  if (node.parent == kNone) return true;
  factor.offset -= state.bodies[at(plan.nodes[at(node.parent)].body)].p;
  ws.factors[at(node.parent)].A += shift(A, factor.offset);
  return true;
}

// Leaves to root: the node's load, less what its freedoms take, goes to its parent.
void reduce_load(const PlanNode& node, Bias biased, NodeFactor& factor, Workspace& ws) {
  if (factor.rows == 0) return;
  Spatial b = factor.load;
  factor.bias = {{0, 0, 0}, {0, 0, 0}};
  if (biased == Bias::kApplied) {
    const Spatial& bias = ws.bias[at(node.joint)];
    factor.bias.ang = node.side * bias.ang;
    factor.bias.lin = node.side * bias.lin - cross(factor.bias.ang, get_arm(ws.frames[at(node.joint)], node));
    b = b -
        (node.leaf ? Spatial{factor.A.M.xx * factor.bias.lin, factor.A.I * factor.bias.ang} : factor.A * factor.bias);
  }
  for (int k = 0; k < factor.freedoms; ++k) {
    Pivot& pivot = factor.pivots[k];
    pivot.beta = dot(pivot.s, b);
    b = b - (pivot.beta * pivot.inverse) * pivot.U;
  }
  if (node.parent == kNone) return;
  Spatial& parent = ws.factors[at(node.parent)].load;
  parent.lin += b.lin;
  parent.ang += b.ang + cross(factor.offset, b.lin);
}

// The wrench A a − b that the joint puts on the child, as multipliers on its follower.
void update_multipliers(const PlanNode& node, const NodeFactor& factor, const Spatial& a, Workspace& ws) {
  const JointFrame& f = ws.frames[at(node.joint)];
  const Spatial carried = node.leaf ? Spatial{factor.A.M.xx * a.lin, factor.A.I * a.ang} : factor.A * a;
  const Vec3 force = node.side * (carried.lin - factor.load.lin);
  const Vec3 moment = node.side * (carried.ang - factor.load.ang) - cross(get_arm(f, node), force);
  double* multipliers = &ws.multipliers[at(node.joint) * kRows];
  for (int r = 0; r < 3; ++r) {
    multipliers[r] = has_row(factor.rows, r) ? dot(column(f.n, r), force) : 0;
    multipliers[kRotX + r] = has_row(factor.rows, kRotX + r) ? dot(column(f.m, r), moment) : 0;
  }
}

// Root to leaves: the node's acceleration from its parent's.
void update_acceleration(const Plan& plan, const PlanNode& node, const NodeFactor& factor, Workspace& ws) {
  Spatial a{{0, 0, 0}, {0, 0, 0}};
  if (node.parent != kNone) {
    const Spatial& parent = ws.accelerations[at(plan.nodes[at(node.parent)].body)];
    a = {parent.lin + cross(parent.ang, factor.offset), parent.ang};
  }
  for (int k = factor.freedoms - 1; k >= 0; --k) {
    const Pivot& pivot = factor.pivots[k];
    a = a + ((pivot.beta - dot(pivot.U, a)) * pivot.inverse) * pivot.s;
  }
  a = a + factor.bias;
  update_multipliers(node, factor, a, ws);
  ws.accelerations[at(node.body)] = a;
}

Spatial solve_free(const Plan& plan, const PlanNode& node, const NodeFactor& factor, const Workspace& ws) {
  if (!node.leaf) return solve(factor.free, factor.A, factor.load);
  const PlanBody& body = plan.bodies[at(node.body)];
  const Mat3& R = ws.kinematics[at(node.body)].R;
  return {(1.0 / body.mass) * factor.load.lin, R * (body.inverse * transpose_times(R, factor.load.ang))};
}

}  // namespace

int factor(const Plan& plan, const State& state, Workspace& ws) noexcept {
  const int count = static_cast<int>(plan.nodes.size());
  for (int k = 0; k < count; ++k) {
    const int body = plan.nodes[at(k)].body;
    const double m = plan.bodies[at(body)].mass;
    ws.factors[at(k)].A = {{m, m, m, 0, 0, 0}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, ws.kinematics[at(body)].J};
  }
  for (int k = count - 1; k >= 0; --k)
    if (!factor_node(plan, state, plan.nodes[at(k)], ws.factors[at(k)], ws)) return k;
  if (!plan.loops.empty()) factor_loops(plan, state, ws);
  return kNone;
}

bool has_finite_block(const Plan& plan, const Workspace& ws, int node) noexcept {
  const Articulated& A = ws.factors[at(node)].A;
  double sum = ((A.M.xx + A.M.yy) + (A.M.zz + A.I.xx)) + (A.I.yy + A.I.zz);
  if (const int joint = plan.nodes[at(node)].joint; joint != kNone)
    sum += dot(ws.frames[at(joint)].r_base, ws.frames[at(joint)].r_follower);
  return std::isfinite(sum);
}

void sweep(const Plan& plan, Workspace& ws, Bias bias) noexcept {
  const int count = static_cast<int>(plan.nodes.size());
  for (int k = count - 1; k >= 0; --k) reduce_load(plan.nodes[at(k)], bias, ws.factors[at(k)], ws);
  for (double& lambda : ws.multipliers) lambda = 0;
  for (int k = 0; k < count; ++k) {
    const PlanNode& node = plan.nodes[at(k)];
    const NodeFactor& factor = ws.factors[at(k)];
    if (factor.rows == 0)
      ws.accelerations[at(node.body)] = solve_free(plan, node, factor, ws);
    else
      update_acceleration(plan, node, factor, ws);
  }
}

void solve(const Plan& plan, Workspace& ws) noexcept {
  for (std::size_t k = 0; k < plan.nodes.size(); ++k) ws.factors[k].load = ws.forces[at(plan.nodes[k].body)];
  sweep(plan, ws, Bias::kApplied);
  if (!plan.loops.empty()) close_loops(plan, ws);
}

}  // namespace unlatch
