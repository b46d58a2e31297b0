#include "kernel/compile/model_hash.h"

#include <bit>
#include <type_traits>
#include <utility>

#include "kernel/elements/kinds/kinds.h"

namespace unlatch {
namespace {

class Hasher {
 public:
  template <class... T>
  void add(const T&... values) {
    (add_one(values), ...);
  }
  std::uint64_t get() const { return hash_; }

 private:
  void add_word(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x9E3779B97F4A7C15ull;
    hash_ ^= hash_ >> 32;
  }
  void add_one(double value) { add_word(std::bit_cast<std::uint64_t>(value)); }
  void add_one(int value) { add_word(static_cast<std::uint64_t>(value)); }
  void add_one(bool value) { add_word(value ? 1 : 0); }
  void add_one(std::uint8_t value) { add_word(value); }
  void add_one(const Eigen::Quaterniond& q) { add(q.w(), q.x(), q.y(), q.z()); }
  template <class D>
  void add_one(const Eigen::MatrixBase<D>& m) {
    for (Eigen::Index c = 0; c < m.cols(); ++c)
      for (Eigen::Index r = 0; r < m.rows(); ++r) add_one(static_cast<double>(m(r, c)));
  }
  template <class E>
  requires std::is_enum_v<E>
  void add_one(E value) { add_word(static_cast<std::uint64_t>(value)); }
  template <class T>
  void add_one(const std::optional<T>& value) {
    add(value.has_value());
    if (value) add(*value);
  }
  template <class T>
  void add_one(const std::vector<T>& values) {
    add(static_cast<int>(values.size()));
    for (const T& value : values) add(value);
  }
  void add_one(const Profile::Harmonic& h) { add(h.amplitude, h.frequency, h.phase); }
  void add_one(const Profile& p) {
    add(p.kind, p.value, p.initial, p.final, p.tau, p.times, p.values, p.harmonics);
    if (p.kind == Profile::Kind::kLaw) add(p.law);
  }
  template <class Scaled>
  void add_scaling(const Scaled& s) {
    add(s.scale, s.offset, s.scale_channel, s.offset_channel);
  }
  void add_one(const TableAxis& a) { add(a.knots, a.below, a.above); }
  void add_one(const Table& t) {
    add(t.axes, t.values, t.interpolation);
    add_scaling(t);
  }
  void add_one(const LawStep& s) { add(s.kind, s.subject, s.value); }
  void add_one(const Law& l) {
    add(l.steps);
    add_scaling(l);
  }
  void add_one(const MassLaw::Knot& k) { add(k.at, k.mass, k.centre, k.inertia); }
  void add_one(const MassLaw& l) { add(l.of, l.knots, l.jet_damping, l.exit); }
  void add_one(const FlexibleBody& f) {
    add(f.frequencies, f.damping, f.momentum, f.first, f.second, f.initial, f.initial_rate);
  }
  void add_one(const Body& b) {
    add(b.mass, b.inertia, b.p_WB, b.q_WB, b.v_WB, b.w_WB_B);
    // Hashed only where they exist: models without them keep their hash.
    if (b.law) add(*b.law);
    if (b.flexible) add(*b.flexible);
    if (b.marker) add(b.marker->body, b.marker->position, b.marker->shape, b.marker->turn);
  }
  void add_one(const JointMode& m) { add(m.rows); }
  void add_one(const Joint& j) {
    add(j.base, j.follower, j.point_base, j.point_follower, j.axes, j.rotation_axes, j.follower_axes, j.universal,
        j.modes, j.mode);
    if (j.share != 1) add(j.share);
    if (j.share_length) add(*j.share_length);
  }
  void add_one(const Gravity& g) { add(g.uniform, g.mu, g.centre); }
  void add_one(const Planet& p) {
    add(p.radius, p.flattening, p.mu, p.j2, p.rate, p.meridian, p.pole, p.centre, p.falling, p.velocity,
        p.gradient_torque);
  }
  void add_one(const Atmosphere& a) { add(a.kind, a.altitudes, a.densities, a.pressures); }
  void add_one(const Wind& w) { add(w.altitudes, w.velocities); }
  void add_one(const Environment& e) {
    add(e.planet, e.atmosphere, e.wind, e.launch.latitude, e.launch.longitude, e.launch.altitude, e.launch.azimuth);
  }
  void add_one(const Vec3& v) { add(v.x, v.y, v.z); }
  void add_one(const geometry::ProfilePoint& p) { add(p.z, p.r); }
  void add_one(const geometry::Shape& s) {
    add(s.kind, s.from, s.to, s.radius, s.end_radius, s.size, s.q_BS.w, s.q_BS.x, s.q_BS.y, s.q_BS.z, s.normal,
        s.points, s.profile, s.half, s.side);
  }
  void add_one(const Surface& s) { add(s.body, s.shapes); }
  void add_one(const std::pair<int, int>& p) { add(p.first, p.second); }
  void add_one(const Impulse& i) { add(i.body, i.frame, i.point, i.linear, i.angular, i.channel); }
  void add_one(const Channel& c) { add(c.initial, c.minimum, c.maximum, c.safe); }
  void add_one(const Sensor& s) {
    add(s.kind, s.subject, s.axis, s.point);
    if (s.other != kNone) add(s.other);
  }
  void add_one(const Quantity& q) { add(q.kind, q.subject, q.other, q.part, q.direction, q.other_direction, q.point); }
  void add_one(const Condition& c) { add(c.kind, c.subject, c.axis, c.threshold, c.below, c.parts); }
  void add_one(const Action& a) { add(a.kind, a.subject, a.mode, a.value, a.duration); }
  void add_one(const Event& e) {
    add(e.when, e.delay, e.then, e.repeat);
    if (e.crossing) add(e.crossing);
  }

  // An element, as its kind lists its numbers.
  template <class Item>
  requires requires(const Item& item) { item.on; }
  void add_one(const Item& item) {
    for_each_kind([&](auto kind) {
      if constexpr (std::is_same_v<std::vector<Item>, std::remove_cvref_t<decltype(kind.of(std::declval<Model&>()))>>)
        kind.list_numbers(item, [&](const auto&... values) { add(values...); });
    });
  }

  std::uint64_t hash_ = 0xCBF29CE484222325ull;
};

}  // namespace

std::uint64_t calc_model_hash(const Model& model, const PlanOptions& options) {
  Hasher hasher;
  hasher.add(options.dt, options.max_splits, options.root, model.bodies, model.joints, model.gravity, model.loads,
             model.point_springs, model.joint_springs, model.plane_torsions, model.channels,
             static_cast<int>(model.signals.size()), model.sensors, model.events);
  if (!model.surfaces.empty()) hasher.add(model.surfaces, model.contacts, model.contact_substeps);
  // Hashed only where they exist: models without them keep their hash. The kinds of elements above are hashed in any
  // case; all others follow here.
  std::size_t number = 0;
  for_each_kind([&](auto kind) {
    constexpr std::size_t kHashedAbove = 5;  // loads to contacts
    if (number++ >= kHashedAbove && !kind.of(model).empty()) hasher.add(kind.of(model));
  });
  if (model.environment.planet) hasher.add(model.environment);
  if (!model.impulses.empty()) hasher.add(model.impulses);
  if (!model.quantities.empty()) hasher.add(model.quantities);
  if (!model.tables.empty()) hasher.add(model.tables);
  if (!model.laws.empty()) hasher.add(model.laws);
  return hasher.get();
}

}  // namespace unlatch
