// Environment as the plan has it, and what a body meets in it at one instant.
#pragma once

#include "kernel/environment/air.h"
#include "kernel/environment/field.h"
#include "kernel/environment/planet.h"

namespace unlatch {

struct PlanEnvironment {
  bool exists = false;   // there is a planet
  bool has_air = false;  // there is an atmosphere
  PlanPlanet planet;
  Vec3 launch_point{0, 0, 0};     // surface axes, m
  Mat3 launch_axes = kIdentity3;  // in surface axes
};
// Motion of a point beside the planet, seen from its centre in inertial space.
struct Flight {
  PlanetPlace place;  // pole axes
  Vec3 v;             // pole axes, m/s
  Vec3 over_surface;  // the velocity over the turning planet, pole axes, m/s
};
// Of the point p that moves with v; W.
Flight calc_flight(const PlanPlanet& planet, double t, const Vec3& p, const Vec3& v) noexcept;

// Air and wind of a plan.
struct AirAround {
  AirView air;
  std::span<const WindKnot> wind;
};

// Air as a body meets it.
struct AirFlow {
  AirState air;
  Vec3 velocity;            // of the body relative to the air, in its axes: u, v, w; m/s
  double speed;             // its size, m/s
  double dynamic_pressure;  // ½ ρ V², Pa
};
// `R`: body axes in W.
AirFlow calc_air_flow(const PlanPlanet& planet, const AirAround& around, const Flight& flight, const Mat3& R) noexcept;

// α = atan2(w, u) and β = asin(v / V) of a velocity relative to the air, rad; 0 at rest.
double calc_angle_of_attack(const Vec3& velocity) noexcept;
double calc_sideslip(const Vec3& velocity) noexcept;

// Angle above the horizon, and from north towards east, of a velocity in north, east, down, rad; 0 at rest.
double calc_path_angle(const Vec3& velocity) noexcept;
double calc_azimuth(const Vec3& velocity) noexcept;

// Roll, pitch, yaw of axes from others: R = Rz(yaw) Ry(pitch) Rx(roll), rad; pitch within ±π/2.
Vec3 calc_euler(const Mat3& R) noexcept;

}  // namespace unlatch
