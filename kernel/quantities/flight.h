// Quantities of a body beside the planet: its place, the air there, its motion over the planet and around it.
#pragma once

#include "kernel/elements/gravity.h"
#include "kernel/quantities/bodies.h"
#include "kernel/quantities/quantity_calc.h"
#include "unlatch/elementary.h"

namespace unlatch::quantities {

inline Flight get_flight(const Instant& now, const Evaluation& ev, int body) {
  const MotionT<double> motion = get_motion(ev, body);
  return calc_flight(now.plan.environment.planet, now.t, motion.p, motion.v);
}

inline Vec3 to_local(const Flight& flight, const Vec3& v) { return transpose_times(flight.place.axes, v); }

// --- The place -------------------------------------------------------------------------------------------------------

inline void calc_altitude(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = get_flight(now, ev, own.subject).place.geodetic.altitude;
}

inline void calc_latitude(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Geodetic g = get_flight(now, ev, own.subject).place.geodetic;
  out[0] = elementary::atan2(g.sine, g.cosine);
}

inline void calc_geocentric_latitude(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Vec3 r = get_flight(now, ev, own.subject).place.r;
  out[0] = elementary::atan2(r.z, std::sqrt(r.x * r.x + r.y * r.y));
}

// A vector of pole axes, in surface axes.
inline Vec3 to_surface(const Instant& now, const Vec3& v) {
  double sine, cosine;
  elementary::sincos(get_turn(now.plan.environment.planet, now.t), sine, cosine);
  return turn_back(sine, cosine, v);
}

inline void calc_longitude(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Vec3 r = to_surface(now, get_flight(now, ev, own.subject).place.r);
  out[0] = elementary::atan2(r.y, r.x);
}

inline void calc_launch_position(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const PlanEnvironment& environment = now.plan.environment;
  const Vec3 r = to_surface(now, get_flight(now, ev, own.subject).place.r);
  put(out, transpose_times(environment.launch_axes, r - environment.launch_point));
}

inline void calc_launch_velocity(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Vec3 v = to_surface(now, get_flight(now, ev, own.subject).over_surface);
  put(out, transpose_times(now.plan.environment.launch_axes, v));
}

// --- The air ---------------------------------------------------------------------------------------------------------

template <double AirState::*value>
void calc_air_value(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Flight flight = get_flight(now, ev, own.subject);
  out[0] = calc_air(get_air(now.plan).air, flight.place.geodetic.altitude).*value;
}

inline AirFlow get_air_flow(const Instant& now, const Evaluation& ev, int body) {
  return calc_air_flow(now.plan.environment.planet, get_air(now.plan), get_flight(now, ev, body),
                       read_kinematics(ev, body).R);
}

inline void calc_mach(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const AirFlow flow = get_air_flow(now, ev, own.subject);
  out[0] = flow.speed / flow.air.speed_of_sound;
}

inline void calc_dynamic_pressure(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = get_air_flow(now, ev, own.subject).dynamic_pressure;
}

inline void calc_airspeed(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = get_air_flow(now, ev, own.subject).speed;
}

inline void calc_air_velocity(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  put(out, get_air_flow(now, ev, own.subject).velocity);
}

// An angle of a velocity in body axes or in north, east, down.
template <double (*calc_angle)(const Vec3&) noexcept>
void calc_air_angle(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_angle(get_air_flow(now, ev, own.subject).velocity);
}

// --- Motion ----------------------------------------------------------------------------------------------------------

inline void calc_own_gravity(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const PlanPlanet& planet = now.plan.environment.planet;
  const Vec3 p = get_motion(ev, own.subject).p;
  const Vec3 o = calc_origin(planet, now.t).r;
  Vec3 g = calc_free_fall(now.plan, o, p);
  if (planet.falling) g -= (planet.mu / (dot(o, o) * norm(o))) * o;  // what W falls with
  put(out, g);
}

inline void calc_local_velocity(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Flight flight = get_flight(now, ev, own.subject);
  put(out, to_local(flight, flight.over_surface));
}

template <double (*calc_angle)(const Vec3&) noexcept>
void calc_surface_angle(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Flight flight = get_flight(now, ev, own.subject);
  out[0] = calc_angle(to_local(flight, flight.over_surface));
}

template <double (*calc_angle)(const Vec3&) noexcept>
void calc_inertial_angle(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Flight flight = get_flight(now, ev, own.subject);
  out[0] = calc_angle(to_local(flight, flight.v));
}

inline void calc_inertial_position(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  put(out, calc_origin(now.plan.environment.planet, now.t).r + get_motion(ev, own.subject).p);
}

inline void calc_inertial_velocity(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  put(out, calc_origin(now.plan.environment.planet, now.t).v + get_motion(ev, own.subject).v);
}

inline void calc_euler_angles(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const Flight flight = get_flight(now, ev, own.subject);
  const Mat3 local = now.plan.environment.planet.axes * flight.place.axes, R = read_kinematics(ev, own.subject).R;
  put(out, calc_euler({transpose_times(local, R.x), transpose_times(local, R.y), transpose_times(local, R.z)}));
}

// Axes of an orbit at a place: radially out, along the motion, across it; the radius, and the rate about the third.
struct OrbitAxes {
  Mat3 R;       // in W
  double rate;  // rad/s
};
inline OrbitAxes calc_orbit_axes(const Vec3& r, const Vec3& v) {
  const Vec3 moment = cross(r, v);
  const double distance = norm(r), size = norm(moment);
  const Vec3 up = (1 / distance) * r, across = (1 / size) * moment;
  return {{up, cross(across, up), across}, size / (distance * distance)};
}

// From the other body, or from the planet's centre along the body's own orbit.
struct OrbitMotion {
  OrbitAxes axes;
  Vec3 p, v;  // W
};
inline OrbitMotion get_orbit_motion(const Instant& now, const Evaluation& ev, const PlanQuantity& own) {
  const OriginMotion origin = calc_origin(now.plan.environment.planet, now.t);
  const MotionT<double> a = get_motion(ev, own.subject);
  if (own.other == kGround) {
    const Vec3 r = origin.r + a.p, v = origin.v + a.v;
    return {calc_orbit_axes(r, v), r, v};
  }
  const MotionT<double> b = get_motion(ev, own.other);
  return {calc_orbit_axes(origin.r + b.p, origin.v + b.v), a.p - b.p, a.v - b.v};
}

inline void calc_orbit_position(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const OrbitMotion motion = get_orbit_motion(now, ev, own);
  put(out, transpose_times(motion.axes.R, motion.p));
}

inline void calc_orbit_velocity(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  const OrbitMotion motion = get_orbit_motion(now, ev, own);
  const Vec3 spin = motion.axes.rate * motion.axes.R.z;
  put(out, transpose_times(motion.axes.R, motion.v - cross(spin, motion.p)));
}

}  // namespace unlatch::quantities
