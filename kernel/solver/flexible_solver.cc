// A flexible body in the tree. With A, B, E the block of its frame's acceleration a and its modal ones η'', b and f
// their loads, and for every marker X a + J η'' + β its acceleration:
//
//   outboard    a marker that has the block A_c and the load l_c adds
//               A += Xᵀ A_c X,  B += Xᵀ A_c J,  E += Jᵀ A_c J,  b += Xᵀ (l_c − A_c β),  f += Jᵀ (l_c − A_c β)
//   held by it  the marker's acceleration takes the place of the frame's, a = Y (a_m − β) − D η'', Y = X⁻¹, D = Y J:
//               A' = Yᵀ A Y,  B' = Yᵀ (B − A D),  E' = E − Dᵀ B − Bᵀ D + Dᵀ A D,
//               b' = Yᵀ (b + A δ),  f' = f + Bᵀ δ − Dᵀ (b + A δ),  δ = Y β
//   then        η'' is eliminated: A'' = A' − B' E'⁻¹ B'ᵀ,  b'' = b' − B' E'⁻¹ f'; it comes back as
//               η'' = E'⁻¹ f' − W a_m,  W = E'⁻¹ B'ᵀ
//
// 6-vectors: lin, ang, world axes. Cost O(m² (m + markers)).
#include "kernel/solver/flexible_solver.h"

#include "kernel/dynamics/flexible.h"
#include "kernel/solver/dense_ldl.h"

namespace unlatch {
namespace {

using Six = double[6];

template <class Block>
void read_six(const double* blocks, const Place& place, Spatial Block::*member, Six& out) {
  const Spatial a = read(blocks, place, member);
  const double numbers[6] = {a.lin.x, a.lin.y, a.lin.z, a.ang.x, a.ang.y, a.ang.z};
  for (int i = 0; i < 6; ++i) out[i] = numbers[i];
}
Spatial to_spatial(const Six& a) { return {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}}; }

// (lin, ang) → (lin + ang × arm, ang), and its transpose for wrenches: (lin, ang + arm × lin).
void move_motion(const double* arm, double sign, double* a) {
  const double x = sign * arm[0], y = sign * arm[1], z = sign * arm[2];
  a[0] += a[4] * z - a[5] * y;
  a[1] += a[5] * x - a[3] * z;
  a[2] += a[3] * y - a[4] * x;
}
void move_wrench(const double* arm, double sign, double* w) {
  const double x = sign * arm[0], y = sign * arm[1], z = sign * arm[2];
  w[3] += y * w[2] - z * w[1];
  w[4] += z * w[0] - x * w[2];
  w[5] += x * w[1] - y * w[0];
}
double dot6(const double* a, const double* b) {
  return ((a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]) + ((a[3] * b[3] + a[4] * b[4]) + a[5] * b[5]);
}
// Symmetric 6 × 6 times a vector.
void times6(const double* A, const double* x, double* out) {
  for (int i = 0; i < 6; ++i) out[i] = dot6(A + 6 * i, x);
}

// Xᵀ A X in place: moves columns as wrenches, then rows.
void move_block(const double* arm, double sign, double* A) {
  for (int i = 0; i < 6; ++i) move_wrench(arm, sign, A + 6 * i);
  for (int i = 0; i < 6; ++i)
    for (int k = i + 1; k < 6; ++k) {
      const double swap = A[6 * i + k];
      A[6 * i + k] = A[6 * k + i];
      A[6 * k + i] = swap;
    }
  for (int i = 0; i < 6; ++i) move_wrench(arm, sign, A + 6 * i);
}

// An articulated block as a 6 × 6 matrix by rows: (M H; Hᵀ I).
void to_matrix(const Articulated& block, double* A) {
  const auto set = [A](int row, int column, double entry) { A[6 * row + column] = A[6 * column + row] = entry; };
  const auto set_symmetric = [&](int first, const Sym3& s) {
    const double rows[3][3] = {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}};
    for (int i = 0; i < 3; ++i)
      for (int k = i; k < 3; ++k) set(first + i, first + k, rows[i][k]);
  };
  const auto set_coupling = [&](int k, const Vec3& column) {
    set(0, 3 + k, column.x);
    set(1, 3 + k, column.y);
    set(2, 3 + k, column.z);
  };
  set_symmetric(0, block.M);
  set_symmetric(3, block.I);
  set_coupling(0, block.H.x);
  set_coupling(1, block.H.y);
  set_coupling(2, block.H.z);
}
// The block of a symmetric 6 × 6 matrix by rows, from its upper triangle.
Articulated to_block(const double* A) {
  const auto get = [A](int row, int column) { return A[6 * row + column]; };
  const auto get_symmetric = [&](int i) -> Sym3 {
    return {get(i, i), get(i + 1, i + 1), get(i + 2, i + 2), get(i, i + 1), get(i, i + 2), get(i + 1, i + 2)};
  };
  const auto get_coupling = [&](int k) -> Vec3 { return {get(0, 3 + k), get(1, 3 + k), get(2, 3 + k)}; };
  return {get_symmetric(0), {get_coupling(0), get_coupling(1), get_coupling(2)}, get_symmetric(3)};
}

// The triangle of a symmetric matrix that its reader takes: to_block() the upper, factor_ldl() the lower.
enum class Triangle { kUpper, kLower };

struct Node {
  const PlanFlexible& body;
  ModalShape shape;
  ModalWork work;
  Place place;
};

// Place of the marker that holds the body.
const Place& get_inboard_place(const PlanData& plan, const Evaluation& ev, const PlanFlexible& body) {
  return ev.places[at(plan.markers[at(body.inboard)].body)];
}

// The body's own block, and its load.
void init_node(const Node& node, Evaluation& ev, const Sweep& sweep, bool with_block, Six& b) {
  const PlanFlexible& body = node.body;
  const double* blocks = ev.blocks.data();
  const int m = body.modes;
  const bool pushed = sweep.source == Source::kForces;
  for (int k = 0; k < m; ++k) node.work.free[k] = pushed ? node.work.force[k] : 0;
  for (double& n : b) n = 0;
  if (pushed) read_six(blocks, node.place, &SharedLane::force, b);
  if (!with_block) return;

  const double* eta = ev.auxiliary.now.data() + body.auxiliary;
  const Mat3 R = read(blocks, node.place, &BodyLane::R);
  Vec3 moment{0, 0, 0};
  for (int k = 0; k < m; ++k) moment += eta[k] * node.shape.get_momentum(k);
  moment = R * moment;
  const Sym3 masses{body.mass, body.mass, body.mass, 0, 0, 0};
  // −(m c)~: a turn about the origin accelerates the centre of mass
  const Mat3 coupling{{0, -moment.z, moment.y}, {moment.z, 0, -moment.x}, {-moment.y, moment.x, 0}};
  to_matrix({masses, coupling, read(blocks, node.place, &SharedLane::inertia)}, node.work.A);
  for (int k = 0; k < m; ++k) {
    // Σ m u × Φ_k = Σ m r × Φ_k + Σ η_l Σ m Φ_l × Φ_k
    Vec3 turning = cross_of(node.shape.get_first(k));
    for (int l = 0; l < m; ++l) turning += eta[l] * cross_of(node.shape.get_second(l, k));
    for (int l = 0; l <= k; ++l) node.work.E(k, l) = trace(node.shape.get_second(k, l));
    const Vec3 push = R * node.shape.get_momentum(k);
    turning = R * turning;
    const double column[6] = {push.x, push.y, push.z, turning.x, turning.y, turning.z};
    for (int i = 0; i < 6; ++i) node.work.B[k][i] = column[i];
    if (body.implicit && sweep.gamma_h != 0)
      node.work.E(k, k) += sweep.gamma_h * (sweep.gamma_h * node.shape.stiffness[k] + node.shape.damping[k]);
  }
}

// Takes in a marker that something may hang on.
void add_marker(const PlanData& plan, const Node& node, Evaluation& ev, const Sweep& sweep, int i, bool with_block,
                Six& b) {
  const PlanMarker& marker = plan.markers[at(i)];
  const MarkerWork work = get_marker(node.body, i, ev);
  const Place place = ev.places[at(marker.body)];
  const double* blocks = ev.blocks.data();
  const int m = node.body.modes;
  Six load = {};
  if (!marker.bare)
    read_six(blocks, place, &SubtreeLane::load, load);
  else if (sweep.source == Source::kForces)
    read_six(blocks, place, &SharedLane::force, load);
  if (!marker.bare && (with_block || sweep.biased)) {
    double A[36];
    to_matrix(read(blocks, place, &SubtreeLane::A), A);
    if (sweep.biased) {
      Six push;
      times6(A, work.bias, push);
      for (int k = 0; k < 6; ++k) load[k] -= push[k];
    }
    if (with_block) {
      for (int k = 0; k < m; ++k) {
        Six column;
        times6(A, work.columns[k], column);
        for (int l = 0; l <= k; ++l) node.work.E(k, l) += dot6(column, work.columns[l]);
        move_wrench(work.arm, 1, column);
        for (int n = 0; n < 6; ++n) node.work.B[k][n] += column[n];
      }
      move_block(work.arm, 1, A);
      for (int k = 0; k < 36; ++k) node.work.A[k] += A[k];
    }
  }
  for (int k = 0; k < m; ++k) node.work.free[k] += dot6(work.columns[k], load);
  move_wrench(work.arm, 1, load);
  for (int k = 0; k < 6; ++k) b[k] += load[k];
}

// At the marker that holds the body: D, E' and B' from A, B and E.
void move_to_marker(const Node& node, const MarkerWork& marker) {
  const int m = node.body.modes;
  const ModalWork& w = node.work;
  for (int k = 0; k < m; ++k) {
    for (int i = 0; i < 6; ++i) w.D[k][i] = marker.columns[k][i];
    move_motion(marker.arm, -1, w.D[k]);
  }
  for (int k = 0; k < m; ++k) {
    Six push;
    times6(w.A, w.D[k], push);
    for (int l = k; l < m; ++l) w.E(l, k) += (dot6(w.D[l], push) - dot6(w.D[l], w.B[k])) - dot6(w.B[l], w.D[k]);
    for (int i = 0; i < 6; ++i) w.C[k][i] = w.B[k][i] - push[i];
    move_wrench(marker.arm, -1, w.C[k]);
  }
}

// The loads at the marker that holds the body: b' and, in `free`, f'.
void move_loads(const Node& node, const MarkerWork& marker, bool biased, Six& b) {
  const ModalWork& w = node.work;
  const int m = node.body.modes;
  if (biased) {
    Six delta, push;
    for (int i = 0; i < 6; ++i) delta[i] = marker.bias[i];
    move_motion(marker.arm, -1, delta);
    times6(w.A, delta, push);
    for (int i = 0; i < 6; ++i) b[i] += push[i];
    for (int k = 0; k < m; ++k) w.free[k] += dot6(w.B[k], delta);
  }
  for (int k = 0; k < m; ++k) w.free[k] -= dot6(w.D[k], b);
  move_wrench(marker.arm, -1, b);
}

// Eliminates the modal coordinates: W, and A'' in the lower or the upper triangle of `left`.
void eliminate_modes(const Node& node, Triangle triangle, double* left) {
  const ModalWork& w = node.work;
  const int m = node.body.modes;
  for (int i = 0; i < 6 * m; ++i) w.W.numbers[i] = w.C.numbers[i];
  for (int i = 0; i < 6; ++i) solve_ldl(w.E, m, w.W.numbers + i, 6);
  for (int k = 0; k < m; ++k)
    for (int i = 0; i < 6; ++i)
      for (int j = triangle == Triangle::kUpper ? i : 0; j < (triangle == Triangle::kUpper ? 6 : i + 1); ++j)
        left[6 * i + j] -= w.C[k][i] * w.W[k][j];
}

// Backward pass for one body. False if a pivot vanishes.
bool eliminate(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const PlanFlexible& body, bool with_block) {
  const Node node{body, get_shape(plan, body), get_work(body, ev), ev.places[at(body.body)]};
  const ModalWork& w = node.work;
  const int m = body.modes;
  const bool held = body.inboard != kNone;
  const MarkerWork holder = get_marker(body, held ? body.inboard : body.first_marker, ev);
  Six b;
  init_node(node, ev, sweep, with_block, b);
  for (int i = body.first_marker; i < body.first_marker + body.markers; ++i)
    if (i != body.inboard) add_marker(plan, node, ev, sweep, i, with_block, b);

  if (with_block) {
    double left[36];
    for (int i = 0; i < 36; ++i) left[i] = w.A[i];
    if (held) {
      move_to_marker(node, holder);
      move_block(holder.arm, -1, left);
    } else {
      for (int i = 0; i < 6 * m; ++i) w.C.numbers[i] = w.B.numbers[i];
    }
    if (!factor_ldl(w.E, m)) return false;
    eliminate_modes(node, held ? Triangle::kUpper : Triangle::kLower, left);
    for (int i = 0; i < 36; ++i) w.root.entries[i] = left[i];
    if (!held && !factor_ldl(w.root, 6)) return false;
    if (held) add(ev.blocks.data(), get_inboard_place(plan, ev, body), &SubtreeLane::A, to_block(left));
  }
  if (held) move_loads(node, holder, sweep.biased, b);
  for (int k = 0; k < m; ++k)
    for (int i = 0; i < 6; ++i) b[i] -= w.W[k][i] * w.free[k];
  solve_ldl(w.E, m, w.free);
  if (held)
    add(ev.blocks.data(), get_inboard_place(plan, ev, body), &SubtreeLane::load, to_spatial(b));
  else
    for (int i = 0; i < 6; ++i) w.root_load[i] = b[i];
  return true;
}

void substitute(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const PlanFlexible& body) {
  const ModalWork w = get_work(body, ev);
  const int m = body.modes;
  double* blocks = ev.blocks.data();
  Six a;
  if (body.inboard == kNone) {
    for (int i = 0; i < 6; ++i) a[i] = w.root_load[i];
    solve_ldl(w.root, 6, a);
  } else {
    read_six(blocks, get_inboard_place(plan, ev, body), &SharedLane::acceleration, a);
  }
  for (int k = 0; k < m; ++k) w.acceleration[k] = w.free[k] - dot6(w.W[k], a);
  if (body.inboard != kNone) {
    const MarkerWork holder = get_marker(body, body.inboard, ev);
    for (int i = 0; i < 6 && sweep.biased; ++i) a[i] -= holder.bias[i];
    move_motion(holder.arm, -1, a);
    for (int k = 0; k < m; ++k)
      for (int i = 0; i < 6; ++i) a[i] -= w.D[k][i] * w.acceleration[k];
  }
  write(blocks, ev.places[at(body.body)], &SharedLane::acceleration, to_spatial(a));
  for (int i = body.first_marker; i < body.first_marker + body.markers; ++i) {
    if (i == body.inboard) continue;
    const MarkerWork marker = get_marker(body, i, ev);
    Six carried;
    for (int k = 0; k < 6; ++k) carried[k] = a[k];
    move_motion(marker.arm, 1, carried);
    for (int k = 0; k < 6; ++k) {
      for (int l = 0; l < m; ++l) carried[k] += marker.columns[l][k] * w.acceleration[l];
      if (sweep.biased) carried[k] += marker.bias[k];
    }
    write(blocks, ev.places[at(plan.markers[at(i)].body)], &SharedLane::acceleration, to_spatial(carried));
  }
}

// Calls run(body, node) for the flexible bodies of a group.
template <class Run>
void for_bodies(const PlanData& plan, const Group& group, const Run& run) {
  if (group.kind != BodyKind::kFlexible) return;
  for (int lane = 0; lane < group.count; ++lane) {
    const int node = plan.lane_nodes[at(group.first + lane)];
    run(plan.flexible[at(plan.bodies[at(plan.nodes[at(node)].body)].flexible)], node);
  }
}

}  // namespace

int eliminate_flexible(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Group& group,
                       bool factor) noexcept {
  int bad = kNone;
  for_bodies(plan, group, [&](const PlanFlexible& body, int node) {
    if (!eliminate(plan, ev, sweep, body, factor)) bad = node;
  });
  return bad;
}

void substitute_flexible(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const Group& group) noexcept {
  for_bodies(plan, group, [&](const PlanFlexible& body, int) { substitute(plan, ev, sweep, body); });
}

}  // namespace unlatch
