#include "kernel/dynamics/flexible.h"

#include <utility>

#include "kernel/elements/gravity.h"

namespace unlatch {
namespace {

Vec3 read(const double* from) { return {from[0], from[1], from[2]}; }
void write(double* to, const Vec3& a) {
  to[0] = a.x;
  to[1] = a.y;
  to[2] = a.z;
}

// Σ_k a_k x_k of m vectors.
Vec3 combine(const double* vectors, const double* sizes, int m) {
  Vec3 sum{0, 0, 0};
  for (int k = 0; k < m; ++k) sum += sizes[k] * read(vectors + 3 * k);
  return sum;
}

// A sum of moments.
struct Dense3 {
  double n[9];

  operator Moment() const { return {n}; }
};
void add(Dense3& to, double size, Moment matrix) {
  for (int i = 0; i < 9; ++i) to.n[i] += size * matrix.n[i];
}
Vec3 times(const Dense3& a, const Vec3& x) {
  return {(a.n[0] * x.x + a.n[1] * x.y) + a.n[2] * x.z, (a.n[3] * x.x + a.n[4] * x.y) + a.n[5] * x.z,
          (a.n[6] * x.x + a.n[7] * x.y) + a.n[8] * x.z};
}
Vec3 transpose_times(const Dense3& a, const Vec3& x) {
  return {(a.n[0] * x.x + a.n[3] * x.y) + a.n[6] * x.z, (a.n[1] * x.x + a.n[4] * x.y) + a.n[7] * x.z,
          (a.n[2] * x.x + a.n[5] * x.y) + a.n[8] * x.z};
}

// Arrays of a body and of a marker, one behind the other: `take(n)` returns the place of the next n numbers.
template <class Number, class Take>
ModalShapeOf<Number> arrange_shape(int m, Take take) {
  ModalShapeOf<Number> s;
  s.modes = m;
  s.momentum = take(3 * m);
  s.first = take(9 * m);
  s.second = take(9 * m * m);
  s.stiffness = take(m);
  s.damping = take(m);
  return s;
}
template <class Number, class Take>
MarkerShapeOf<Number> arrange_marker_shape(int m, Take take) {
  MarkerShapeOf<Number> s;
  s.displacement = take(3 * m);
  s.turn = take(3 * m);
  return s;
}
template <class Take>
ModalWork arrange_work(int m, Take take) {
  ModalWork w;
  w.force = take(m);
  w.acceleration = take(m);
  w.A = take(6 * 6);
  w.B = {take(6 * m)};
  w.E = {take(m * m), m};
  w.C = {take(6 * m)};
  w.W = {take(6 * m)};
  w.D = {take(6 * m)};
  w.free = take(m);
  w.root = {take(6 * 6), 6};
  w.root_load = take(6);
  return w;
}
template <class Take>
MarkerWork arrange_marker(int m, Take take) {
  MarkerWork w;
  w.columns = {take(6 * m)};
  w.arm = take(3);
  w.bias = take(6);
  return w;
}
// Two ways to take: from memory, and for the count alone.
template <class Number>
auto take_from(Number* memory) {
  return [next = memory](int n) mutable { return std::exchange(next, next + n); };
}
auto count_into(int& size) {
  return [&size](int n) -> double* {
    size += n;
    return nullptr;
  };
}

MarkerShape get_marker_shape(const PlanData& plan, const PlanMarker& marker, int m) {
  return arrange_marker_shape<const double>(m, take_from(plan.modal.data() + marker.numbers));
}

struct Coordinates {
  const double *eta, *rate;
};
Coordinates get_coordinates(const PlanFlexible& body, const Evaluation& ev) {
  const double* eta = ev.auxiliary.now.data() + body.auxiliary;
  return {eta, eta + body.modes};
}

// Σ m u Φ_kᵀ
Dense3 calc_moment(const ModalShape& s, const double* eta, int k) {
  Dense3 out{};
  add(out, 1, s.get_first(k));
  for (int l = 0; l < s.modes; ++l) add(out, eta[l], s.get_second(l, k));
  return out;
}

// Σ m u uᵀ = P0 + Σ η_k (G_kᵀ + Σ m u Φ_kᵀ), since Σ m Φ_k uᵀ = G_kᵀ + Σ η_l H_kl.
Sym3 calc_inertia(const PlanFlexible& body, const ModalShape& s, const double* eta) {
  const Sym3& J0 = body.inertia;
  const double half = 0.5 * (J0.xx + J0.yy + J0.zz);
  Dense3 P{{half - J0.xx, -J0.xy, -J0.xz, -J0.xy, half - J0.yy, -J0.yz, -J0.xz, -J0.yz, half - J0.zz}};
  for (int k = 0; k < s.modes; ++k) {
    const Dense3 moment = calc_moment(s, eta, k);
    const double* G = s.get_first(k).n;
    const Dense3 transposed{{G[0], G[3], G[6], G[1], G[4], G[7], G[2], G[5], G[8]}};
    add(P, eta[k], moment);
    add(P, eta[k], transposed);
  }
  const double t = trace(P);
  return {t - P.n[0], t - P.n[4], t - P.n[8], -P.n[1], -P.n[2], -P.n[5]};
}

// The marker's turn in its body as a Rodrigues vector g, and how it changes.
struct Turn {
  Vec3 g, g_rate, w;  // w: of the marker relative to the body, body axes
  double scale;       // 1 / (1 + g²)
};
Turn calc_turn(const MarkerShape& shape, const Coordinates& c, int m) {
  Turn t;
  t.g = 0.5 * combine(shape.turn, c.eta, m);
  t.g_rate = 0.5 * combine(shape.turn, c.rate, m);
  t.scale = 1 / (1 + dot(t.g, t.g));
  t.w = (2 * t.scale) * (t.g_rate + cross(t.g, t.g_rate));
  return t;
}

// A marker seen from its body.
struct Carried {
  Vec3 u;       // from the body's origin, body axes
  Vec3 arm;     // u in world axes
  Vec3 u_rate;  // by the modal rates alone, body axes
  Turn turn;
  Mat3 R;  // of the body
};
Carried calc_carried(const PlanData& plan, const PlanMarker& marker, const Mat3& R, const Coordinates& c) {
  const int m = plan.flexible[at(marker.flexible)].modes;
  const MarkerShape shape = get_marker_shape(plan, marker, m);
  const Vec3 u = marker.position + combine(shape.displacement, c.eta, m);
  return {u, R * u, combine(shape.displacement, c.rate, m), calc_turn(shape, c, m), R};
}

// x = p + R u, q ⊗ (1, g); in the marker's axes its angular velocity is R_relᵀ (w + w_rel).
BodyState carry(const Carried& marker, const BodyState& body) {
  const Vec3& g = marker.turn.g;
  const Quat turn{1, g.x, g.y, g.z};
  return {body.p + marker.arm, normalized(body.q * turn), body.v + marker.R * (cross(body.w, marker.u) + marker.u_rate),
          transpose_times(rotation_matrix(turn), body.w + marker.turn.w)};
}

// The force of a mode beyond that of an explicit one, in a stage of ROS2; see compliance.h.
double calc_modal_lead(const PlanFlexible& body, const ModalShape& s, const Implicit& implicit, const Evaluation& ev,
                       int k) {
  const double gamma_h = implicit.gamma_h, rate = ev.auxiliary.now[at(body.auxiliary + body.modes + k)];
  if (implicit.stage == ImplicitStage::kOff) return 0;
  if (implicit.stage == ImplicitStage::kFirst) return -gamma_h * s.stiffness[k] * rate;
  const double first_rate = 2 * ev.auxiliary.sum[at(body.auxiliary + k)];
  const double first_acceleration = 2 * ev.auxiliary.sum[at(body.auxiliary + body.modes + k)];
  const double pivot = gamma_h * (gamma_h * s.stiffness[k] + s.damping[k]);
  return 2 * pivot * first_acceleration - gamma_h * s.stiffness[k] * (rate - 2 * first_rate);
}

BodyState read_body(const Evaluation& ev, int body) {
  const MotionT<double> m = read(ev.blocks.data(), ev.places[at(body)], &BodyLane::motion);
  return {m.p, m.q, m.v, m.w};
}

void write_body(Evaluation& ev, int body, const BodyState& s) {
  write(ev.blocks.data(), ev.places[at(body)], &BodyLane::motion, {s.p, s.q, s.v, s.w});
}

}  // namespace

ModalShape get_shape(const PlanData& plan, const PlanFlexible& body) noexcept {
  return arrange_shape<const double>(body.modes, take_from(plan.modal.data() + body.numbers));
}
int get_shape_size(int m) noexcept {
  int size = 0;
  arrange_shape<double>(m, count_into(size));
  return size;
}
ModalShapeOf<double> place_shape(int m, double* numbers) noexcept {
  return arrange_shape<double>(m, take_from(numbers));
}

int get_marker_shape_size(int m) noexcept {
  int size = 0;
  arrange_marker_shape<double>(m, count_into(size));
  return size;
}
MarkerShapeOf<double> place_marker_shape(int m, double* numbers) noexcept {
  return arrange_marker_shape<double>(m, take_from(numbers));
}

ModalWork get_work(const PlanFlexible& body, Evaluation& ev) noexcept {
  return arrange_work(body.modes, take_from(ev.modal.data() + body.work));
}
int get_work_size(int m) noexcept {
  int size = 0;
  arrange_work(m, count_into(size));
  return size;
}

MarkerWork get_marker(const PlanFlexible& body, int marker, Evaluation& ev) noexcept {
  const int m = body.modes, before = get_work_size(m) + (marker - body.first_marker) * get_marker_size(m);
  return arrange_marker(m, take_from(ev.modal.data() + body.work + before));
}
int get_marker_size(int m) noexcept {
  int size = 0;
  arrange_marker(m, count_into(size));
  return size;
}

BodyState calc_marker_state(const PlanData& plan, const PlanMarker& marker, const BodyState& body,
                            const double* coordinates, const double* rates) noexcept {
  return carry(calc_carried(plan, marker, rotation_matrix(body.q), {coordinates, rates}), body);
}

void update_markers(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const BodyState frame = read_body(ev, body.body);
    const Mat3 R = rotation_matrix(frame.q);
    const Coordinates c = get_coordinates(body, ev);
    for (int i = body.first_marker; i < body.first_marker + body.markers; ++i) {
      const PlanMarker& marker = plan.markers[at(i)];
      const Carried carried = calc_carried(plan, marker, R, c);
      write_body(ev, marker.body, carry(carried, frame));
      const MarkerWork work = get_marker(body, i, ev);
      const MarkerShape shape = get_marker_shape(plan, marker, body.modes);
      const Turn& t = carried.turn;
      write(work.arm, carried.arm);
      for (int k = 0; k < body.modes; ++k) {
        const Vec3 axis = read(shape.turn + 3 * k);
        write(work.columns[k], R * read(shape.displacement + 3 * k));
        write(work.columns[k] + 3, R * (t.scale * (axis + cross(t.g, axis))));
      }
    }
  }
}

void update_flexible_kinematics(const PlanData& plan, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (const PlanFlexible& body : plan.flexible) {
    const Place place = ev.places[at(body.body)];
    write(blocks, place, &SharedLane::inertia,
          rotate(read(blocks, place, &BodyLane::R),
                 calc_inertia(body, get_shape(plan, body), get_coordinates(body, ev).eta)));
  }
}

// a = a_body + α × r + Σ Φ η'' + w × (w × r) + 2 w × Φ η';   α_marker = α + Σ Ψ' η'' + w × w_rel − 2 (g·g') / (1 + g²)
// w_rel
void update_marker_biases(const PlanData& plan, RowTarget kind, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const Place place = ev.places[at(body.body)];
    const Mat3 R = read(ev.blocks.data(), place, &BodyLane::R);
    const Vec3 w = read(ev.blocks.data(), place, &BodyLane::w_W);
    const Coordinates c = get_coordinates(body, ev);
    for (int i = body.first_marker; i < body.first_marker + body.markers; ++i) {
      const MarkerWork work = get_marker(body, i, ev);
      Spatial bias{{0, 0, 0}, {0, 0, 0}};
      if (kind == RowTarget::kAcceleration) {
        const MarkerShape shape = get_marker_shape(plan, plan.markers[at(i)], body.modes);
        const Turn t = calc_turn(shape, c, body.modes);
        const Vec3 w_rel = R * t.w;
        bias.lin =
            cross(w, cross(w, read(work.arm))) + 2.0 * cross(w, R * combine(shape.displacement, c.rate, body.modes));
        bias.ang = cross(w, w_rel) - (2 * t.scale * dot(t.g, t.g_rate)) * w_rel;
      }
      write(work.bias, bias.lin);
      write(work.bias + 3, bias.ang);
    }
  }
}

// In body axes, with s = S η:
//   force   m g − 2 w × s' − w × (w × s)
//   torque  s × g − 2 (tr Q w − Qᵀ w),  Q = Σ m u u'ᵀ
//   mode k  S_k·g − 2 w·Σ η'_l Σ m Φ_l × Φ_k − wᵀ P_k w + w² tr P_k − ω² η − 2 ζ ω η',  P_k = Σ m u Φ_kᵀ
void add_flexible_forces(const PlanData& plan, double t, const Implicit& implicit, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (const PlanFlexible& body : plan.flexible) {
    const Place place = ev.places[at(body.body)];
    const ModalShape s = get_shape(plan, body);
    const ModalWork work = get_work(body, ev);
    const Coordinates c = get_coordinates(body, ev);
    const int m = body.modes;
    const Mat3 R = read(blocks, place, &BodyLane::R);
    const Vec3 w = read(blocks, place, &BodyLane::motion).w;
    const Vec3 g = transpose_times(R, calc_free_fall(plan, t, read(blocks, place, &BodyLane::motion).p));
    const Vec3 moment = combine(s.momentum, c.eta, m), flow = combine(s.momentum, c.rate, m);
    Dense3 Q{};
    for (int k = 0; k < m; ++k) {
      const Dense3 P = calc_moment(s, c.eta, k);
      add(Q, c.rate[k], P);
      Dense3 turning{};
      for (int l = 0; l < m; ++l) add(turning, c.rate[l], s.get_second(l, k));
      work.force[k] =
          ((dot(s.get_momentum(k), g) - 2 * dot(w, cross_of(turning))) - (dot(w, times(P, w)) - dot(w, w) * trace(P))) -
          (s.stiffness[k] * c.eta[k] + s.damping[k] * c.rate[k]);
      if (body.implicit) work.force[k] += calc_modal_lead(body, s, implicit, ev, k);
    }
    const Vec3 force = (body.mass * g - 2.0 * cross(w, flow)) - cross(w, cross(w, moment));
    const Vec3 torque = cross(moment, g) - 2.0 * (trace(Q) * w - transpose_times(Q, w));
    add(blocks, place, &SharedLane::force, {R * force, R * torque});
  }
}

void update_modal_rates(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(body, ev);
    for (int k = 0; k < body.modes; ++k) {
      ev.auxiliary.rate[at(body.auxiliary + k)] = ev.auxiliary.now[at(body.auxiliary + body.modes + k)];
      ev.auxiliary.rate[at(body.auxiliary + body.modes + k)] = work.acceleration[k];
    }
  }
}

void lead_modal_rates(const PlanData& plan, const Implicit& implicit, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible)
    for (int k = 0; k < body.modes; ++k) {
      const std::size_t x = at(body.auxiliary + k), v = at(body.auxiliary + body.modes + k);
      const double before =
          implicit.stage == ImplicitStage::kSecond ? 4 * ev.auxiliary.sum[v] : 0;  // the sum holds half of a1
      ev.auxiliary.rate[x] += implicit.gamma_h * (ev.auxiliary.rate[v] - before);
    }
}

void clear_modal_forces(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(body, ev);
    for (int k = 0; k < body.modes; ++k) work.force[k] = 0;
  }
}

void add_modal_displacements(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible)
    for (int k = 0; k < body.modes; ++k) ev.auxiliary.now[at(body.auxiliary + k)] += get_work(body, ev).acceleration[k];
}

void add_modal_velocities(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible)
    for (int k = 0; k < body.modes; ++k)
      ev.auxiliary.now[at(body.auxiliary + body.modes + k)] += get_work(body, ev).acceleration[k];
}

Balance calc_flexible_balance(const PlanData& plan, const PlanFlexible& body, const BodyState& state,
                              const double* coordinates) noexcept {
  const ModalShape s = get_shape(plan, body);
  const int m = body.modes;
  const double *eta = coordinates, *rate = coordinates + m;
  const Mat3 R = rotation_matrix(state.q);
  const Vec3 moment = combine(s.momentum, eta, m);
  const Vec3 flow = cross(state.w, moment) + combine(s.momentum, rate, m);
  Dense3 Q{};
  double modal = 0;
  for (int k = 0; k < m; ++k) {
    add(Q, rate[k], calc_moment(s, eta, k));
    for (int l = 0; l < m; ++l) modal += rate[k] * rate[l] * trace(s.get_second(k, l));
  }
  const Vec3 spin = calc_inertia(body, s, eta) * state.w, turning = cross_of(Q), flow_W = R * flow;
  Balance out;
  out.momentum = body.mass * state.v + flow_W;
  out.angular_momentum = (cross(state.p, out.momentum) + cross(R * moment, state.v)) + R * (spin + turning);
  out.kinetic = ((0.5 * body.mass * dot(state.v, state.v) + dot(state.v, flow_W)) +
                 (0.5 * dot(state.w, spin) + dot(state.w, turning))) +
                0.5 * modal;
  return out;
}

}  // namespace unlatch
