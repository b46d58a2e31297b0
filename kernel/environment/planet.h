// A planet of revolution: its axes, places on it, and the motion of W's origin beside it.
//
// *Pole axes* are at rest in inertial space: z is the pole, x lies in the plane of the pole and W's x (W's y if the
// pole is along x). *Surface axes* turn with the planet: z is the pole, x points at longitude 0. Both begin at the
// centre.
//
// The geodetic latitude φ and the altitude h of a point at ρ = √(x² + y²) and z follow from Bowring's relation (Survey
// Review 181, 1976),
//
//   tan φ = (z + e'² b sin³ β) / (ρ − e² a cos³ β),   tan β = (1 − f) tan φ
//
// taken four times from tan β = z / ((1 − f) ρ), with sines and cosines as quotients. tests/kernel/environment_test.cc
// has its error against GeographicLib. h = ρ cos φ + z sin φ − a √(1 − e² sin² φ) loses no digits anywhere.
#pragma once

#include <cmath>

#include "unlatch/math.h"
#include "unlatch/model/environment.h"

namespace unlatch {

struct PlanPlanet {
  double radius = 0, flattening = 0, mu = 0, j2 = 0, rate = 0, meridian = 0;
  Mat3 axes = kIdentity3;                   // pole axes in W
  Vec3 origin{0, 0, 0}, velocity{0, 0, 0};  // of W's origin, seen from the centre, at t = 0; W, m, m/s
  bool falling = false, gradient_torque = false;
  // Of the ellipse on which the origin falls, see calc_origin(): m, m, rad/s, and e times cosine and sine of the
  // eccentric anomaly at t = 0.
  double distance = 0, semi_major = 0, mean_motion = 0, e_cosine = 0, e_sine = 0;
};
PlanPlanet compile_planet(const Planet& planet);

// W's origin, seen from the planet's centre; W.
struct OriginMotion {
  Vec3 r, v;  // m, m/s
};
// At t. Falling, it follows an ellipse in f and g functions of the change of the eccentric anomaly, for which Kepler's
// equation is solved by at most kKeplerSteps steps; two, mostly. An error of the place, some 1e-16 of the way since
// t = 0, is no force on the bodies: their field is the difference from the one there.
inline constexpr int kKeplerSteps = 32;
OriginMotion calc_origin(const PlanPlanet& planet, double t) noexcept;

// The normal of the ellipsoid through a point, and the altitude there.
struct Geodetic {
  double sine, cosine;  // of the latitude
  double altitude;      // m
};
inline Geodetic calc_geodetic(double radius, double flattening, double rho, double z) {
  constexpr int kTimes = 4;
  const double e2 = flattening * (2 - flattening), across = e2 * radius;
  const double along = across / (1 - flattening);  // e'² b = e² a / (1 − f)
  double s = z, c = (1 - flattening) * rho;        // of β, times any number
  double sine = 0, cosine = 1;
  for (int i = 0; i < kTimes; ++i) {
    const double size = std::sqrt(s * s + c * c);
    if (!(size > 0)) break;  // at the centre any direction serves
    s /= size;
    c /= size;
    sine = z + along * (s * (s * s));
    cosine = rho - across * (c * (c * c));
    s = (1 - flattening) * sine;
    c = cosine;
  }
  const double size = std::sqrt(sine * sine + cosine * cosine);
  if (size > 0) {
    sine /= size;
    cosine /= size;
  }
  return {sine, cosine, (rho * cosine + z * sine) - radius * std::sqrt(1 - e2 * (sine * sine))};
}

// A place, and the axes there. Pole axes or surface axes.
struct PlanetPlace {
  Vec3 r;  // from the centre, m
  Geodetic geodetic;
  double sine, cosine;  // of the angle about the pole from x; at the pole that of x itself
  Mat3 axes;            // columns: north, east, down
};
PlanetPlace calc_place(const PlanPlanet& planet, const Vec3& r) noexcept;
// From latitude, longitude (from x) and altitude; rad, rad, m.
PlanetPlace place_at(const PlanPlanet& planet, double latitude, double longitude, double altitude) noexcept;

// The angle of surface axes about the pole from pole axes, rad.
inline double get_turn(const PlanPlanet& planet, double t) { return planet.meridian + planet.rate * t; }
// A vector about the pole, by −angle: from pole axes to surface axes.
inline Vec3 turn_back(double sine, double cosine, const Vec3& v) {
  return {cosine * v.x + sine * v.y, cosine * v.y - sine * v.x, v.z};
}
inline Vec3 turn_on(double sine, double cosine, const Vec3& v) { return turn_back(-sine, cosine, v); }

// Velocity of what rests on the planet, pole axes, m/s.
inline Vec3 calc_surface_velocity(const PlanPlanet& planet, const Vec3& r) {
  return {-planet.rate * r.y, planet.rate * r.x, 0};
}

}  // namespace unlatch
