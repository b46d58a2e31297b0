#include "kernel/tree_solver.h"

#include "kernel/kinematics.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A pivot this small beside what it was before the joint's other freedoms were taken out is rounding noise.
constexpr double kSingular = 1e-13;

double dot(const Spatial& a, const Spatial& b) { return unlatch::dot(a.lin, b.lin) + unlatch::dot(a.ang, b.ang); }

Spatial operator*(const ArticulatedInertia& A, const Spatial& s) {
  return {A.M * s.lin + A.H * s.ang, transpose_times(A.H, s.lin) + A.I * s.ang};
}

Sym3 operator+(const Sym3& a, const Sym3& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}

// s − k a aᵀ
Sym3 downdate(const Sym3& s, double k, const Vec3& a) {
  const double kx = k * a.x, ky = k * a.y, kz = k * a.z;
  return {s.xx - kx * a.x, s.yy - ky * a.y, s.zz - kz * a.z, s.xy - kx * a.y, s.xz - kx * a.z, s.yz - ky * a.z};
}

void downdate(ArticulatedInertia& A, double k, const Spatial& U) {
  A.M = downdate(A.M, k, U.lin);
  A.I = downdate(A.I, k, U.ang);
  A.H.x -= (k * U.ang.x) * U.lin;
  A.H.y -= (k * U.ang.y) * U.lin;
  A.H.z -= (k * U.ang.z) * U.lin;
}

// Adds A, given at a point `r` away from the parent's origin, to the parent's: Xᵀ A X with a_point = a + α × r.
//   H' = H − M r̃,   I' = I + r̃ H' − Hᵀ r̃
void add_shifted(ArticulatedInertia& parent, const ArticulatedInertia& A, const Vec3& r) {
  const Sym3& M = A.M;
  // columns of M r̃ are M (e_k × …): r̃ e_x = (0, r.z, −r.y), r̃ e_y = (−r.z, 0, r.x), r̃ e_z = (r.y, −r.x, 0)
  const Mat3 H{A.H.x - M * Vec3{0, r.z, -r.y}, A.H.y - M * Vec3{-r.z, 0, r.x}, A.H.z - M * Vec3{r.y, -r.x, 0}};
  const Vec3 tx = cross(r, H.x), ty = cross(r, H.y), tz = cross(r, H.z);  // columns of r̃ H'
  // Hᵀ r̃: column k is Hᵀ (r̃ e_k)
  const Vec3 ux = transpose_times(A.H, Vec3{0, r.z, -r.y});
  const Vec3 uy = transpose_times(A.H, Vec3{-r.z, 0, r.x});
  const Vec3 uz = transpose_times(A.H, Vec3{r.y, -r.x, 0});
  parent.M = parent.M + M;
  parent.H.x += H.x;
  parent.H.y += H.y;
  parent.H.z += H.z;
  parent.I = parent.I + Sym3{A.I.xx + tx.x - ux.x, A.I.yy + ty.y - uy.y, A.I.zz + tz.z - uz.z,
                             A.I.xy + ty.x - uy.x, A.I.xz + tz.x - uz.x, A.I.yz + tz.y - uz.y};
}

// Which rows hold a node to its parent or to the ground: none for one that moves freely.
RowSet get_node_rows(const Plan& plan, const State& state, const PlanNode& node) {
  return node.joint == kNone ? RowSet{0} : get_active_rows(plan, state, node.joint);
}

const Vec3& get_arm(const JointFrame& f, const PlanNode& node) { return node.side > 0 ? f.r_follower : f.r_base; }

Vec3 unit(int k) { return {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0}; }

// Direction of the freedom that row r would take, at the node's body origin.
Spatial calc_freedom(const Workspace& ws, const PlanNode& node, RowSet rows, int r) {
  if (rows == 0) return r < kRotX ? Spatial{unit(r), {0, 0, 0}} : Spatial{{0, 0, 0}, unit(r - kRotX)};
  const JointFrame& f = ws.frames[at(node.joint)];
  if (r < kRotX) return {column(f.n, r), {0, 0, 0}};
  const Vec3& axis = column(f.m, r - kRotX);
  return {cross(get_arm(f, node), axis), axis};
}

// The joint's bias as seen from the parent at the child's origin.
Spatial calc_node_bias(const Workspace& ws, const PlanNode& node) {
  const Spatial& bias = ws.bias[at(node.joint)];
  const Vec3 ang = node.side * bias.ang;
  return {node.side * bias.lin - cross(ang, get_arm(ws.frames[at(node.joint)], node)), ang};
}

Vec3 calc_offset_from_parent(const Plan& plan, const State& state, const PlanNode& node) {
  return state.bodies[at(node.body)].p - state.bodies[at(plan.nodes[at(node.parent)].body)].p;
}

}  // namespace

int factor(const Plan& plan, const State& state, Workspace& ws) noexcept {
  const int count = static_cast<int>(plan.nodes.size());
  for (int k = 0; k < count; ++k) {
    const double m = plan.bodies[at(plan.nodes[at(k)].body)].mass;
    ws.inertias[at(k)] = {
        {m, m, m, 0, 0, 0}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, ws.kinematics[at(plan.nodes[at(k)].body)].J};
  }
  for (int k = count - 1; k >= 0; --k) {
    const PlanNode& node = plan.nodes[at(k)];
    const RowSet rows = get_node_rows(plan, state, node);
    ArticulatedInertia& A = ws.reduced[at(k)];
    A = ws.inertias[at(k)];
    for (int r = 0; r < kRows; ++r) {
      Pivot& pivot = ws.pivots[at(k) * kRows + at(r)];
      pivot.inverse = 0;
      if (has_row(rows, r)) continue;
      pivot.s = calc_freedom(ws, node, rows, r);
      pivot.U = A * pivot.s;
      const double D = dot(pivot.s, pivot.U);
      if (!(D > kSingular * dot(pivot.s, ws.inertias[at(k)] * pivot.s))) return k;
      pivot.inverse = 1.0 / D;
      downdate(A, pivot.inverse, pivot.U);
    }
    if (rows != 0 && node.parent != kNone)
      add_shifted(ws.inertias[at(node.parent)], A, calc_offset_from_parent(plan, state, node));
  }
  return kNone;
}

void solve(const Plan& plan, const State& state, Workspace& ws) noexcept {
  const int count = static_cast<int>(plan.nodes.size());
  for (int k = 0; k < count; ++k) ws.loads[at(k)] = ws.forces[at(plan.nodes[at(k)].body)];

  for (int k = count - 1; k >= 0; --k) {  // leaves to root: loads
    const PlanNode& node = plan.nodes[at(k)];
    const RowSet rows = get_node_rows(plan, state, node);
    Spatial& b = ws.reduced_loads[at(k)];
    b = ws.loads[at(k)];
    if (rows != 0) {
      const Spatial drag = ws.inertias[at(k)] * calc_node_bias(ws, node);
      b = {b.lin - drag.lin, b.ang - drag.ang};
    }
    for (int r = 0; r < kRows; ++r) {
      if (has_row(rows, r)) continue;
      Pivot& pivot = ws.pivots[at(k) * kRows + at(r)];
      pivot.beta = dot(pivot.s, b);
      const double u = pivot.beta * pivot.inverse;
      b = {b.lin - u * pivot.U.lin, b.ang - u * pivot.U.ang};
    }
    if (rows != 0 && node.parent != kNone) {
      Spatial& parent = ws.loads[at(node.parent)];
      parent.lin += b.lin;
      parent.ang += b.ang + cross(calc_offset_from_parent(plan, state, node), b.lin);
    }
  }

  for (double& lambda : ws.multipliers) lambda = 0;
  for (int k = 0; k < count; ++k) {  // root to leaves: accelerations and reactions
    const PlanNode& node = plan.nodes[at(k)];
    const RowSet rows = get_node_rows(plan, state, node);
    Spatial a{{0, 0, 0}, {0, 0, 0}};
    if (rows != 0) {
      if (node.parent != kNone) {
        const Spatial& parent = ws.accelerations[at(plan.nodes[at(node.parent)].body)];
        a = {parent.lin + cross(parent.ang, calc_offset_from_parent(plan, state, node)), parent.ang};
      }
      const JointFrame& f = ws.frames[at(node.joint)];
      const Spatial carried = ws.reduced[at(k)] * a;
      const Vec3 force = node.side * (carried.lin - ws.reduced_loads[at(k)].lin);
      const Vec3 moment = node.side * (carried.ang - ws.reduced_loads[at(k)].ang) - cross(get_arm(f, node), force);
      for (int r = 0; r < kRows; ++r) {
        if (!has_row(rows, r)) continue;
        ws.multipliers[at(node.joint) * kRows + at(r)] =
            r < kRotX ? unlatch::dot(column(f.n, r), force) : unlatch::dot(column(f.m, r - kRotX), moment);
      }
    }
    for (int r = kRows - 1; r >= 0; --r) {
      if (has_row(rows, r)) continue;
      const Pivot& pivot = ws.pivots[at(k) * kRows + at(r)];
      const double u = (pivot.beta - dot(pivot.U, a)) * pivot.inverse;
      a = {a.lin + u * pivot.s.lin, a.ang + u * pivot.s.ang};
    }
    if (rows != 0) {
      const Spatial bias = calc_node_bias(ws, node);
      a = {a.lin + bias.lin, a.ang + bias.ang};
    }
    ws.accelerations[at(node.body)] = a;
  }
}

}  // namespace unlatch
