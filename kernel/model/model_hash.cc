#include "kernel/model/model_hash.h"

#include <bit>

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
  void add_one(const Profile& p) { add(p.kind, p.value, p.initial, p.final, p.tau, p.times, p.values, p.harmonics); }
  void add_one(const MassLaw::Knot& k) { add(k.at, k.mass, k.centre, k.inertia); }
  void add_one(const MassLaw& l) { add(l.of, l.knots, l.jet_damping, l.exit); }
  void add_one(const FlexibleBody& f) {
    add(f.frequencies, f.damping, f.momentum, f.first, f.second, f.initial, f.initial_rate);
  }
  void add_one(const Body& b) {
    add(b.mass, b.inertia, b.p_WB, b.q_WB, b.v_WB, b.w_WB_B);
    // Models without these keep the hash that they have always had.
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
  void add_one(const Load& l) {
    add(l.body, l.kind, l.frame, l.point, l.direction, l.profile, l.channel, l.on);
    if (l.consumption != 0) add(l.consumption, l.tank);
  }
  void add_one(const PointSpring& s) {
    add(s.base, s.follower, s.point_base, s.point_follower, s.stiffness, s.damping, s.free_length, s.push_only, s.on);
  }
  void add_one(const JointSpring& s) {
    add(s.joint, s.axis, s.effort, s.stiffness, s.damping, s.rest, s.on);
    if (s.implicit) add(*s.implicit);
  }
  void add_one(const PlaneTorsion& s) {
    add(s.base, s.follower, s.normal_base, s.axis_follower, s.stiffness, s.damping, s.on);
  }
  void add_one(const Vec3& v) { add(v.x, v.y, v.z); }
  void add_one(const geometry::ProfilePoint& p) { add(p.z, p.r); }
  void add_one(const geometry::Shape& s) {
    add(s.kind, s.from, s.to, s.radius, s.end_radius, s.size, s.q_BS.w, s.q_BS.x, s.q_BS.y, s.q_BS.z, s.normal,
        s.points, s.profile, s.half, s.side);
  }
  void add_one(const Surface& s) { add(s.body, s.shapes); }
  void add_one(const std::pair<int, int>& p) { add(p.first, p.second); }
  void add_one(const Contact& c) {
    add(c.base, c.follower, c.stiffness, c.exponent, c.damping, c.restitution, c.speed, c.friction, c.slip_speed, c.on,
        c.except);
  }
  void add_one(const OneSided& f) {
    add(f.kind, f.pulls, f.joint, f.axis, f.base, f.follower, f.point_base, f.point_follower, f.guide, f.limit,
        f.stroke, f.law, f.preload, f.stiffness, f.gas_length, f.exponent, f.travels, f.forces, f.damping, f.friction,
        f.friction_speed, f.on);
    if (f.drum) add(f.drum->centre, f.drum->axis, f.drum->radius, f.drum->left, f.drum->wound);
  }
  void add_one(const JointFriction& f) { add(f.joint, f.axis, f.coefficient, f.radius, f.speed, f.on); }
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

  std::uint64_t hash_ = 0xCBF29CE484222325ull;
};

}  // namespace

std::uint64_t calc_model_hash(const Model& model, const PlanOptions& options) {
  Hasher hasher;
  hasher.add(options.dt, options.max_splits, options.root, model.bodies, model.joints, model.gravity, model.loads,
             model.point_springs, model.joint_springs, model.plane_torsions, model.channels,
             static_cast<int>(model.signals.size()), model.sensors, model.events);
  if (!model.surfaces.empty()) hasher.add(model.surfaces, model.contacts, model.contact_substeps);
  // Models without these keep the hash that they have always had.
  if (!model.one_sided.empty()) hasher.add(model.one_sided);
  if (!model.frictions.empty()) hasher.add(model.frictions);
  if (!model.impulses.empty()) hasher.add(model.impulses);
  if (!model.quantities.empty()) hasher.add(model.quantities);
  return hasher.get();
}

}  // namespace unlatch
