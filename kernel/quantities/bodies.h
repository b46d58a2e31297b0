// Quantities of bodies: the motion of one, or of one as seen from another.
#pragma once

#include "kernel/elements/gravity.h"
#include "kernel/quantities/quantity_calc.h"
#include "unlatch/elementary.h"

namespace unlatch::quantities {

// Pose and velocity of a body; the ground rests at W.
inline MotionT<double> get_motion(const Evaluation& ev, int body) {
  if (body == kGround) return {{0, 0, 0}, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  return read(ev.blocks.data(), ev.places[at(body)], &BodyLane::motion);
}

// A vector in axes of the body from which it is seen; from the ground in W.
inline Vec3 see_from(const Quat& q, int body, const Vec3& v) {
  return body == kGround ? v : transpose_times(rotation_matrix(q), v);
}

inline void calc_position(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const MotionT<double> a = get_motion(ev, own.subject), b = get_motion(ev, own.other);
  put(out, see_from(b.q, own.other, a.p - b.p));
}

inline void calc_velocity(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const MotionT<double> a = get_motion(ev, own.subject), b = get_motion(ev, own.other);
  put(out, see_from(b.q, own.other, a.v - b.v));
}

inline void calc_rate(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const MotionT<double> a = get_motion(ev, own.subject);
  if (own.other == kGround) return put(out, a.w);
  const MotionT<double> b = get_motion(ev, own.other);
  put(out, a.w - transpose_times(rotation_matrix(a.q), rotation_matrix(b.q) * b.w));
}

inline void calc_attitude(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Quat q = get_motion(ev, own.subject).q;
  const Quat seen = own.other == kGround ? q : conjugate(get_motion(ev, own.other).q) * q;
  out[0] = seen.w;
  put(out + 1, {seen.x, seen.y, seen.z});
}

// The angle of a rotation, 0 to π, rad.
inline double calc_turn(const double* q) { return 2 * elementary::atan2(norm(Vec3{q[1], q[2], q[3]}), std::abs(q[0])); }

inline void calc_axes(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Vec3 axis = rotation_matrix(get_motion(ev, own.subject).q) * own.direction;
  const Vec3 other = rotation_matrix(get_motion(ev, own.other).q) * own.other_direction;
  out[0] = elementary::atan2(norm(cross(axis, other)), dot(axis, other));
}

// Acceleration of a point fixed in the body less `g` (world axes), in body axes. `g`: zero, or for an accelerometer
// free fall.
inline Vec3 calc_point_acceleration(const Evaluation& ev, int body, const Vec3& point, const Vec3& g) {
  const BodyKinematics k = read_kinematics(ev, body);
  const Spatial a = ev.get_acceleration(body);
  const Vec3 r = k.R * point;
  return transpose_times(k.R, (a.lin - g) + (cross(a.ang, r) + cross(k.w, cross(k.w, r))));
}

inline void calc_acceleration(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  put(out, calc_point_acceleration(ev, own.subject, own.point, {0, 0, 0}));
}

inline void calc_angular_acceleration(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  put(out, transpose_times(read_kinematics(ev, own.subject).R, ev.get_acceleration(own.subject).ang));
}

inline void calc_specific_force(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Vec3 point = get_motion(ev, own.subject).p + read_kinematics(ev, own.subject).R * own.point;
  const Vec3 g = calc_free_fall(now.plan, calc_origin_place(now.plan, now.t), point);
  put(out, calc_point_acceleration(ev, own.subject, own.point, g));
}

inline void calc_burnt(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = ev.auxiliary.now[at(now.plan.bodies[at(own.subject)].varying)];
}

}  // namespace unlatch::quantities
