#include "kernel/tree_solver.h"

#include "kernel/kinematics.h"

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

// The pivots of a body that nothing holds: its six unit directions, so that they solve its own block.
void update_free_directions(NodeFactor& node) {
  for (int k = 0; k < 3; ++k) {
    node.pivots[k].s = {column(kIdentity3, k), {0, 0, 0}};
    node.pivots[k + 3].s = {{0, 0, 0}, column(kIdentity3, k)};
  }
  node.freedoms = kRows;
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
    if (node.leaf) return true;  // a single free body: solve_free_leaf() needs no factor
    update_free_directions(factor);
    Articulated rest;
    return eliminate(factor, false, rest);
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
void reduce_load(const PlanNode& node, NodeFactor& factor, Workspace& ws) {
  Spatial b = factor.load;
  if (factor.rows != 0) {
    const JointFrame& f = ws.frames[at(node.joint)];
    const Spatial& bias = ws.bias[at(node.joint)];
    factor.bias.ang = node.side * bias.ang;
    factor.bias.lin = node.side * bias.lin - cross(factor.bias.ang, get_arm(f, node));
    b = b -
        (node.leaf ? Spatial{factor.A.M.xx * factor.bias.lin, factor.A.I * factor.bias.ang} : factor.A * factor.bias);
  }
  for (int k = 0; k < factor.freedoms; ++k) {
    Pivot& pivot = factor.pivots[k];
    pivot.beta = dot(pivot.s, b);
    b = b - (pivot.beta * pivot.inverse) * pivot.U;
  }
  if (factor.rows == 0 || node.parent == kNone) return;
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
  if (factor.rows != 0 && node.parent != kNone) {
    const Spatial& parent = ws.accelerations[at(plan.nodes[at(node.parent)].body)];
    a = {parent.lin + cross(parent.ang, factor.offset), parent.ang};
  }
  for (int k = factor.freedoms - 1; k >= 0; --k) {
    const Pivot& pivot = factor.pivots[k];
    a = a + ((pivot.beta - dot(pivot.U, a)) * pivot.inverse) * pivot.s;
  }
  if (factor.rows != 0) {
    a = a + factor.bias;
    update_multipliers(node, factor, a, ws);
  }
  ws.accelerations[at(node.body)] = a;
}

void solve_free_leaf(const Plan& plan, const PlanNode& node, const NodeFactor& factor, Workspace& ws) {
  const PlanBody& body = plan.bodies[at(node.body)];
  const Mat3& R = ws.kinematics[at(node.body)].R;
  ws.accelerations[at(node.body)] = {(1.0 / body.mass) * factor.load.lin,
                                     R * (body.inverse * transpose_times(R, factor.load.ang))};
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
  return kNone;
}

void solve(const Plan& plan, Workspace& ws) noexcept {
  const int count = static_cast<int>(plan.nodes.size());
  for (int k = 0; k < count; ++k) ws.factors[at(k)].load = ws.forces[at(plan.nodes[at(k)].body)];
  for (int k = count - 1; k >= 0; --k) reduce_load(plan.nodes[at(k)], ws.factors[at(k)], ws);
  for (double& lambda : ws.multipliers) lambda = 0;
  for (int k = 0; k < count; ++k) {
    const PlanNode& node = plan.nodes[at(k)];
    const NodeFactor& factor = ws.factors[at(k)];
    if (node.leaf && factor.rows == 0)
      solve_free_leaf(plan, node, factor, ws);
    else
      update_acceleration(plan, node, factor, ws);
  }
}

}  // namespace unlatch
