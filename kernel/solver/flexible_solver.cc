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

#include <algorithm>

#include "kernel/dynamics/flexible.h"
#include "kernel/solver/dense_ldl.h"

namespace unlatch {
namespace {

int to_int(std::size_t i) { return static_cast<int>(i); }

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

constexpr Spatial kNothing{{0, 0, 0}, {0, 0, 0}};

// The load of the body alone, on its frame; that on its modes is in `free`.
Spatial begin_load(const Node& node, const Evaluation& ev, const Sweep& sweep) {
  const ModalWork& w = node.work;
  for (std::size_t k = 0; k < w.free.size(); ++k) w.free[k] = sweep.source == Source::kForces ? w.force[k] : 0;
  return sweep.source != Source::kNothing ? read(ev.blocks.data(), node.place, &SharedLane::force) : kNothing;
}

// The block of the body alone: A, B, E.
void begin_block(const Node& node, const Evaluation& ev, const Sweep& sweep) {
  const PlanFlexible& body = node.body;
  const double* blocks = ev.blocks.data();
  const double* eta = ev.auxiliary.now.data() + body.auxiliary;
  const Mat3 R = read(blocks, node.place, &BodyLane::R);
  const std::size_t m = node.shape.count_modes();
  Vec3 moment{0, 0, 0};
  for (std::size_t k = 0; k < m; ++k) moment += eta[k] * node.shape.momentum[k];
  moment = R * moment;
  const Sym3 masses{body.mass, body.mass, body.mass, 0, 0, 0};
  // −(m c)~: a turn about the origin accelerates the centre of mass
  const Mat3 coupling{{0, -moment.z, moment.y}, {moment.z, 0, -moment.x}, {-moment.y, moment.x, 0}};
  *node.work.A = to_matrix({masses, coupling, read(blocks, node.place, &SharedLane::inertia)});
  const LowerTriangle& E = node.work.E;
  for (std::size_t k = 0; k < m; ++k) {
    // Σ m u × Φ_k = Σ m r × Φ_k + Σ η_l Σ m Φ_l × Φ_k
    Vec3 turning = cross_of(node.shape.first[k]);
    for (std::size_t l = 0; l < m; ++l) turning += eta[l] * cross_of(node.shape.get_second(l, k));
    for (std::size_t l = 0; l <= k; ++l) E(to_int(k), to_int(l)) = trace(node.shape.get_second(k, l));
    node.work.B[k] = {R * node.shape.momentum[k], R * turning};
    if (body.implicit && sweep.gamma_h != 0)
      E(to_int(k), to_int(k)) += calc_implicit_pivot(node.shape.stiffness[k], node.shape.damping[k], sweep.gamma_h);
  }
}

// Adds an outboard marker, with the blocks of the bodies that it carries; its load is added to `b` and `free`.
void add_marker(const Node& node, Evaluation& ev, const Sweep& sweep, const PlanMarker& marker, const MarkerWork& work,
                bool with_block, Spatial& b) {
  const ModalWork& w = node.work;
  const Place place = ev.places[at(marker.body)];
  const double* blocks = ev.blocks.data();
  Spatial load = kNothing;
  if (!marker.bare)
    load = read(blocks, place, &SubtreeLane::wrench);
  else if (sweep.source != Source::kNothing)
    load = read(blocks, place, &SharedLane::force);
  if (!marker.bare && (with_block || sweep.biased)) {
    const Matrix6 A = to_matrix(read(blocks, place, &SubtreeLane::A));
    if (sweep.biased) load = load - A * *work.bias;
    if (with_block) {
      for (std::size_t k = 0; k < w.B.size(); ++k) {
        const Spatial column = A * work.columns[k];
        for (std::size_t l = 0; l <= k; ++l) w.E(to_int(k), to_int(l)) += dot(column, work.columns[l]);
        w.B[k] = w.B[k] + shift_wrench(column, *work.arm);
      }
      *w.A += shift(A, *work.arm);
    }
  }
  for (std::size_t k = 0; k < w.free.size(); ++k) w.free[k] += dot(work.columns[k], load);
  b = b + shift_wrench(load, *work.arm);
}

// At the marker that holds the body: D, E' and B' from A, B and E.
void move_to_marker(const Node& node, const MarkerWork& marker) {
  const ModalWork& w = node.work;
  const std::size_t m = w.D.size();
  const Vec3 arm = -*marker.arm;
  for (std::size_t k = 0; k < m; ++k) w.D[k] = shift_motion(marker.columns[k], arm);
  for (std::size_t k = 0; k < m; ++k) {
    const Spatial push = *w.A * w.D[k];
    for (std::size_t l = k; l < m; ++l)
      w.E(to_int(l), to_int(k)) += (dot(w.D[l], push) - dot(w.D[l], w.B[k])) - dot(w.B[l], w.D[k]);
    w.C[k] = shift_wrench(w.B[k] - push, arm);
  }
}

// The loads at the marker that holds the body: returns b', and leaves f' in `free`.
Spatial move_loads(const Node& node, const MarkerWork& marker, bool biased, Spatial b) {
  const ModalWork& w = node.work;
  const Vec3 arm = -*marker.arm;
  if (biased) {
    const Spatial delta = shift_motion(*marker.bias, arm);
    b = b + *w.A * delta;
    for (std::size_t k = 0; k < w.free.size(); ++k) w.free[k] += dot(w.B[k], delta);
  }
  for (std::size_t k = 0; k < w.free.size(); ++k) w.free[k] -= dot(w.D[k], b);
  return shift_wrench(b, arm);
}

// Eliminates the modal coordinates: W, and A'' in the lower or the upper triangle of `left`.
void eliminate_modes(const Node& node, Triangle triangle, Matrix6& left) {
  const ModalWork& w = node.work;
  std::copy(w.C.begin(), w.C.end(), w.W.begin());
  solve_ldl(w.E, to_int(w.W.size()), w.W.data());
  for (std::size_t k = 0; k < w.C.size(); ++k) {
    const SixNumbers column = to_numbers(w.C[k]), row = to_numbers(w.W[k]);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = triangle == Triangle::kUpper ? i : 0; j < (triangle == Triangle::kUpper ? 6 : i + 1); ++j)
        left.rows[i][j] -= column[i] * row[j];
  }
}

// The factor of the body and all outboard of it. Adds what is left to the marker that holds the body. False if a pivot
// vanishes.
bool factor(const PlanData& plan, Evaluation& ev, const Node& node, const MarkerWork* holder) {
  const ModalWork& w = node.work;
  Matrix6 left = *w.A;
  if (holder != nullptr) {
    move_to_marker(node, *holder);
    left = shift(left, -*holder->arm);
  } else {
    std::copy(w.B.begin(), w.B.end(), w.C.begin());
  }
  if (!factor_ldl(w.E, node.body.modes)) return false;
  eliminate_modes(node, holder != nullptr ? Triangle::kUpper : Triangle::kLower, left);
  if (holder != nullptr) {
    add(ev.blocks.data(), get_inboard_place(plan, ev, node.body), &SubtreeLane::A, to_block(left));
    return true;
  }
  *w.root = left;
  return factor_ldl(w.root->get_lower(), 6);
}

// Backward pass for one body. False if a pivot vanishes.
bool eliminate(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const PlanFlexible& body, bool with_block) {
  const Node node{body, get_shape(plan, body), get_work(body, ev), ev.places[at(body.body)]};
  const ModalWork& w = node.work;
  const bool held = body.inboard != kNone;
  const MarkerArray markers(body, ev);
  const MarkerWork holder = markers[held ? body.inboard : body.first_marker];
  Spatial b = begin_load(node, ev, sweep);
  if (with_block) begin_block(node, ev, sweep);
  for (int i = body.first_marker; i < body.first_marker + body.markers; ++i)
    if (i != body.inboard) add_marker(node, ev, sweep, plan.markers[at(i)], markers[i], with_block, b);
  if (with_block && !factor(plan, ev, node, held ? &holder : nullptr)) return false;
  if (held) b = move_loads(node, holder, sweep.biased, b);
  for (std::size_t k = 0; k < w.W.size(); ++k) b = b - w.free[k] * w.W[k];
  solve_ldl(w.E, body.modes, w.free.data());
  if (held)
    add(ev.blocks.data(), get_inboard_place(plan, ev, body), &SubtreeLane::wrench, b);
  else
    *w.root_load = b;
  return true;
}

// Acceleration of the frame of a body that nothing holds.
Spatial solve_root(const ModalWork& w) {
  SixNumbers a = to_numbers(*w.root_load);
  solve_ldl(w.root->get_lower(), 6, a.data());
  return to_spatial(a);
}

void substitute(const PlanData& plan, Evaluation& ev, const Sweep& sweep, const PlanFlexible& body) {
  const ModalWork w = get_work(body, ev);
  const std::size_t m = w.W.size();
  double* blocks = ev.blocks.data();
  const bool held = body.inboard != kNone;
  const MarkerArray markers(body, ev);
  Spatial a = held ? read(blocks, get_inboard_place(plan, ev, body), &SharedLane::acceleration) : solve_root(w);
  for (std::size_t k = 0; k < m; ++k) w.acceleration[k] = w.free[k] - dot(w.W[k], a);
  if (held) {
    const MarkerWork holder = markers[body.inboard];
    if (sweep.biased) a = a - *holder.bias;
    a = shift_motion(a, -*holder.arm);
    for (std::size_t k = 0; k < m; ++k) a = a - w.acceleration[k] * w.D[k];
  }
  write(blocks, ev.places[at(body.body)], &SharedLane::acceleration, a);
  for (int i = body.first_marker; i < body.first_marker + body.markers; ++i) {
    if (i == body.inboard) continue;
    const MarkerWork marker = markers[i];
    Spatial carried = shift_motion(a, *marker.arm);
    for (std::size_t k = 0; k < m; ++k) carried = carried + w.acceleration[k] * marker.columns[k];
    if (sweep.biased) carried = carried + *marker.bias;
    write(blocks, ev.places[at(plan.markers[at(i)].body)], &SharedLane::acceleration, carried);
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
