#include "kernel/dynamics/flexible.h"

#include <algorithm>

#include "kernel/elements/gravity.h"

namespace unlatch {
namespace {

// Σ_k a_k x_k
Vec3 combine(std::span<const Vec3> vectors, const double* sizes) {
  Vec3 sum{0, 0, 0};
  for (std::size_t k = 0; k < vectors.size(); ++k) sum += sizes[k] * vectors[k];
  return sum;
}

void add(Moment& to, double size, const Moment& a) {
  to = {to.xx + size * a.xx, to.xy + size * a.xy, to.xz + size * a.xz, to.yx + size * a.yx, to.yy + size * a.yy,
        to.yz + size * a.yz, to.zx + size * a.zx, to.zy + size * a.zy, to.zz + size * a.zz};
}
Moment transpose(const Moment& a) { return {a.xx, a.yx, a.zx, a.xy, a.yy, a.zy, a.xz, a.yz, a.zz}; }
Vec3 times(const Moment& a, const Vec3& x) {
  return {(a.xx * x.x + a.xy * x.y) + a.xz * x.z, (a.yx * x.x + a.yy * x.y) + a.yz * x.z,
          (a.zx * x.x + a.zy * x.y) + a.zz * x.z};
}

// Arrays one behind the other in memory; without memory they are only counted.
class Arrays {
 public:
  explicit Arrays(double* memory) : memory_(memory) {}

  template <class T>
  std::span<T> take(int count) {
    static_assert(sizeof(T) % sizeof(double) == 0);
    const int first = used_;
    used_ += count * static_cast<int>(sizeof(T) / sizeof(double));
    if (memory_ == nullptr) return {};
    return {reinterpret_cast<T*>(memory_ + first), at(count)};
  }
  template <class T>
  T* take_one() {
    return take<T>(1).data();
  }
  int get_used() const { return used_; }

 private:
  double* memory_;
  int used_ = 0;
};

// The one place that says how they lie in memory.
ModalShapeOf<Writable> arrange_shape(int m, Arrays& from) {
  return {.momentum = from.take<Vec3>(m),
          .first = from.take<Moment>(m),
          .second = from.take<Moment>(m * m),
          .stiffness = from.take<double>(m),
          .damping = from.take<double>(m)};
}
MarkerShapeOf<Writable> arrange_marker_shape(int m, Arrays& from) {
  return {.displacement = from.take<Vec3>(m), .turn = from.take<Vec3>(m)};
}
ModalWork arrange_work(int m, Arrays& from) {
  return {.force = from.take<double>(m),
          .A = from.take_one<Matrix6>(),
          .B = from.take<Spatial>(m),
          .E = {from.take<double>(m * m).data(), m},
          .C = from.take<Spatial>(m),
          .W = from.take<Spatial>(m),
          .D = from.take<Spatial>(m),
          .free = from.take<double>(m),
          .root = from.take_one<Matrix6>(),
          .root_load = from.take_one<Spatial>(),
          .acceleration = from.take<double>(m)};
}
MarkerWork arrange_marker(int m, Arrays& from) {
  return {.columns = from.take<Spatial>(m),
          .arm = from.take_one<Vec3>(),
          .turn = from.take_one<MarkerTurn>(),
          .bias = from.take_one<Spatial>()};
}
template <class Arranged>
int count_numbers(Arranged (*arrange)(int, Arrays&), int m) {
  Arrays none(nullptr);
  arrange(m, none);
  return none.get_used();
}
// Arrays of a plan, which are only read.
Arrays get_arrays(const PlanData& plan, std::int32_t first) {
  return Arrays(const_cast<double*>(plan.modal.data()) + first);
}

MarkerShape get_marker_shape(const PlanData& plan, const PlanMarker& marker, int m) {
  Arrays arrays = get_arrays(plan, marker.numbers);
  const MarkerShapeOf<Writable> shape = arrange_marker_shape(m, arrays);
  return {shape.displacement, shape.turn};
}

struct Coordinates {
  const double *eta, *rate;
};
Coordinates get_coordinates(const PlanFlexible& body, const Evaluation& ev) {
  const double* eta = ev.auxiliary.now.data() + body.auxiliary;
  return {eta, eta + body.modes};
}

// Σ m u Φ_kᵀ
Moment calc_moment(const ModalShape& s, const double* eta, std::size_t k) {
  Moment out{};
  add(out, 1, s.first[k]);
  for (std::size_t l = 0; l < s.count_modes(); ++l) add(out, eta[l], s.get_second(l, k));
  return out;
}

// Σ m u uᵀ = P0 + Σ η_k (G_kᵀ + Σ m u Φ_kᵀ), since Σ m Φ_k uᵀ = G_kᵀ + Σ η_l H_kl.
Sym3 calc_inertia(const PlanFlexible& body, const ModalShape& s, const double* eta) {
  const Sym3& J0 = body.inertia;
  const double half = 0.5 * (J0.xx + J0.yy + J0.zz);
  Moment P{half - J0.xx, -J0.xy, -J0.xz, -J0.xy, half - J0.yy, -J0.yz, -J0.xz, -J0.yz, half - J0.zz};
  for (std::size_t k = 0; k < s.count_modes(); ++k) {
    add(P, eta[k], calc_moment(s, eta, k));
    add(P, eta[k], transpose(s.first[k]));
  }
  const double t = trace(P);
  return {t - P.xx, t - P.yy, t - P.zz, -P.xy, -P.xz, -P.yz};
}

MarkerTurn calc_turn(const MarkerShape& shape, const Coordinates& c) {
  MarkerTurn t;
  t.g = 0.5 * combine(shape.turn, c.eta);
  t.g_rate = 0.5 * combine(shape.turn, c.rate);
  t.scale = 1 / (1 + dot(t.g, t.g));
  t.w = (2 * t.scale) * (t.g_rate + cross(t.g, t.g_rate));
  return t;
}

// A marker seen from its body.
struct Carried {
  Vec3 u;       // from the body's origin, body axes
  Vec3 arm;     // u in world axes
  Vec3 u_rate;  // by the modal rates alone, body axes
  MarkerTurn turn;
  Mat3 R;  // of the body
};
Carried calc_carried(const PlanData& plan, const PlanMarker& marker, const Mat3& R, const Coordinates& c) {
  const int m = plan.flexible[at(marker.flexible)].modes;
  const MarkerShape shape = get_marker_shape(plan, marker, m);
  const Vec3 u = marker.position + combine(shape.displacement, c.eta);
  return {u, R * u, combine(shape.displacement, c.rate), calc_turn(shape, c), R};
}

// x = p + R u, q ⊗ (1, g); in the marker's axes its angular velocity is R_relᵀ (w + w_rel).
BodyState carry(const Carried& marker, const BodyState& body) {
  const Vec3& g = marker.turn.g;
  const Quat turn{1, g.x, g.y, g.z};
  return {body.p + marker.arm, normalized(body.q * turn), body.v + marker.R * (cross(body.w, marker.u) + marker.u_rate),
          transpose_times(rotation_matrix(turn), body.w + marker.turn.w)};
}

// The force of a mode beyond that of an explicit one, in a stage of ROS2; see compliance.h. In the second stage the sum
// of rates is the first rate.
double calc_modal_lead(const PlanFlexible& body, const ModalShape& s, const Implicit& implicit, const Auxiliary& x,
                       std::size_t k) {
  const std::size_t place = at(body.auxiliary) + k, rate = place + s.count_modes();
  switch (implicit.stage) {
    case ImplicitStage::kOff:
      return 0;
    case ImplicitStage::kFirst:
      return calc_first_lead(s.stiffness[k], x.now[rate], implicit.gamma_h);
    case ImplicitStage::kSecond:
      return calc_second_lead(s.stiffness[k], s.damping[k], x.now[rate], x.sum[place], x.sum[rate], implicit.gamma_h);
  }
  return 0;
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
  Arrays arrays = get_arrays(plan, body.numbers);
  const ModalShapeOf<Writable> s = arrange_shape(body.modes, arrays);
  return {s.momentum, s.first, s.second, s.stiffness, s.damping};
}
int get_shape_size(int modes) noexcept { return count_numbers(arrange_shape, modes); }
int get_marker_shape_size(int modes) noexcept { return count_numbers(arrange_marker_shape, modes); }
ModalShapeOf<Writable> place_shape(int modes, double* numbers) noexcept {
  Arrays arrays(numbers);
  return arrange_shape(modes, arrays);
}
MarkerShapeOf<Writable> place_marker_shape(int modes, double* numbers) noexcept {
  Arrays arrays(numbers);
  return arrange_marker_shape(modes, arrays);
}

ModalWork get_work(const PlanFlexible& body, Evaluation& ev) noexcept {
  Arrays arrays(ev.modal.data() + body.work);
  return arrange_work(body.modes, arrays);
}
int get_work_size(int modes) noexcept { return count_numbers(arrange_work, modes); }

MarkerArray::MarkerArray(const PlanFlexible& body, Evaluation& ev) noexcept
    : numbers_(ev.modal.data() + body.work + get_work_size(body.modes)),
      size_(get_marker_size(body.modes)),
      modes_(body.modes),
      first_(body.first_marker) {}
MarkerWork MarkerArray::operator[](int marker) const noexcept {
  Arrays arrays(numbers_ + (marker - first_) * size_);
  return arrange_marker(modes_, arrays);
}
MarkerWork get_marker(const PlanFlexible& body, int marker, Evaluation& ev) noexcept {
  return MarkerArray(body, ev)[marker];
}
int get_marker_size(int modes) noexcept { return count_numbers(arrange_marker, modes); }

BodyState calc_marker_state(const PlanData& plan, const PlanMarker& marker, const BodyState& body,
                            const double* coordinates, const double* rates) noexcept {
  return carry(calc_carried(plan, marker, rotation_matrix(body.q), {coordinates, rates}), body);
}

void update_markers(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const BodyState frame = read_body(ev, body.body);
    const Mat3 R = rotation_matrix(frame.q);
    const Coordinates c = get_coordinates(body, ev);
    const MarkerArray markers(body, ev);
    for (int i = body.first_marker; i < body.first_marker + body.markers; ++i) {
      const PlanMarker& marker = plan.markers[at(i)];
      const Carried carried = calc_carried(plan, marker, R, c);
      write_body(ev, marker.body, carry(carried, frame));
      const MarkerWork work = markers[i];
      const MarkerShape shape = get_marker_shape(plan, marker, body.modes);
      const MarkerTurn& t = carried.turn;
      *work.arm = carried.arm;
      *work.turn = t;
      for (std::size_t k = 0; k < work.columns.size(); ++k) {
        const Vec3& axis = shape.turn[k];
        work.columns[k] = {R * shape.displacement[k], R * (t.scale * (axis + cross(t.g, axis)))};
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
    const MarkerArray markers(body, ev);
    for (int i = body.first_marker; i < body.first_marker + body.markers; ++i) {
      const MarkerWork work = markers[i];
      Spatial bias{{0, 0, 0}, {0, 0, 0}};
      if (kind == RowTarget::kAcceleration) {
        const MarkerShape shape = get_marker_shape(plan, plan.markers[at(i)], body.modes);
        const MarkerTurn& t = *work.turn;
        const Vec3 w_rel = R * t.w;
        bias.lin = cross(w, cross(w, *work.arm)) + 2.0 * cross(w, R * combine(shape.displacement, c.rate));
        bias.ang = cross(w, w_rel) - (2 * t.scale * dot(t.g, t.g_rate)) * w_rel;
      }
      *work.bias = bias;
    }
  }
}

// In body axes, with s = S η:
//   force   m g − 2 w × s' − w × (w × s)
//   torque  s × g − 2 (tr Q w − Qᵀ w),  Q = Σ m u u'ᵀ
//   mode k  S_k·g − 2 w·Σ η'_l Σ m Φ_l × Φ_k − wᵀ P_k w + w² tr P_k − ω² η − 2 ζ ω η',  P_k = Σ m u Φ_kᵀ
void add_flexible_forces(const PlanData& plan, const Vec3& origin, const Implicit& implicit, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (const PlanFlexible& body : plan.flexible) {
    const Place place = ev.places[at(body.body)];
    const ModalShape s = get_shape(plan, body);
    const ModalWork work = get_work(body, ev);
    const Coordinates c = get_coordinates(body, ev);
    const std::size_t m = s.count_modes();
    const Mat3 R = read(blocks, place, &BodyLane::R);
    const Vec3 w = read(blocks, place, &BodyLane::motion).w;
    const Vec3 g = transpose_times(R, calc_free_fall(plan, origin, read(blocks, place, &BodyLane::motion).p));
    const Vec3 moment = combine(s.momentum, c.eta), flow = combine(s.momentum, c.rate);
    Moment Q{};
    for (std::size_t k = 0; k < m; ++k) {
      const Moment P = calc_moment(s, c.eta, k);
      add(Q, c.rate[k], P);
      Moment turning{};
      for (std::size_t l = 0; l < m; ++l) add(turning, c.rate[l], s.get_second(l, k));
      work.force[k] =
          ((dot(s.momentum[k], g) - 2 * dot(w, cross_of(turning))) - (dot(w, times(P, w)) - dot(w, w) * trace(P))) -
          (s.stiffness[k] * c.eta[k] + s.damping[k] * c.rate[k]);
      if (body.implicit) work.force[k] += calc_modal_lead(body, s, implicit, ev.auxiliary, k);
    }
    const Vec3 force = (body.mass * g - 2.0 * cross(w, flow)) - cross(w, cross(w, moment));
    const Vec3 torque = cross(moment, g) - 2.0 * (trace(Q) * w - times(transpose(Q), w));
    add(blocks, place, &SharedLane::force, {R * force, R * torque});
  }
}

void update_modal_rates(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(body, ev);
    for (int k = 0; k < body.modes; ++k) {
      ev.auxiliary.rate[at(body.auxiliary + k)] = ev.auxiliary.now[at(body.auxiliary + body.modes + k)];
      ev.auxiliary.rate[at(body.auxiliary + body.modes + k)] = work.acceleration[at(k)];
    }
  }
}

void lead_modal_rates(const PlanData& plan, const Implicit& implicit, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible)
    for (int k = 0; k < body.modes; ++k) {
      const std::size_t x = at(body.auxiliary + k), v = at(body.auxiliary + body.modes + k);
      const double before = implicit.stage == ImplicitStage::kSecond ? 2 * ev.auxiliary.sum[v] : 0;
      ev.auxiliary.rate[x] += implicit.gamma_h * (ev.auxiliary.rate[v] - before);
    }
}

void clear_modal_forces(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(body, ev);
    std::fill(work.force.begin(), work.force.end(), 0.0);
  }
}

void add_modal_displacements(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(body, ev);
    for (int k = 0; k < body.modes; ++k) ev.auxiliary.now[at(body.auxiliary + k)] += work.acceleration[at(k)];
  }
}

void add_modal_velocities(const PlanData& plan, Evaluation& ev) noexcept {
  for (const PlanFlexible& body : plan.flexible) {
    const ModalWork work = get_work(body, ev);
    for (int k = 0; k < body.modes; ++k)
      ev.auxiliary.now[at(body.auxiliary + body.modes + k)] += work.acceleration[at(k)];
  }
}

Balance calc_flexible_balance(const PlanData& plan, const PlanFlexible& body, const BodyState& state,
                              const double* coordinates) noexcept {
  const ModalShape s = get_shape(plan, body);
  const std::size_t m = s.count_modes();
  const double *eta = coordinates, *rate = coordinates + m;
  const Mat3 R = rotation_matrix(state.q);
  const Vec3 moment = combine(s.momentum, eta);
  const Vec3 flow = cross(state.w, moment) + combine(s.momentum, rate);
  Moment Q{};
  double modal = 0;
  for (std::size_t k = 0; k < m; ++k) {
    add(Q, rate[k], calc_moment(s, eta, k));
    for (std::size_t l = 0; l < m; ++l) modal += rate[k] * rate[l] * trace(s.get_second(k, l));
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
