// Gravity of a planet: central term and J2, and the torque of their gradient. With r from the centre, r̂ its direction,
// n the pole and s = r̂·n (Vallado, Fundamentals of Astrodynamics, 8.7):
//
//   g = −μ r / |r|³ − (3/2) J2 μ a² / |r|⁴ ((1 − 5 s²) r̂ + 2 s n)
//   torque = 3 μ / |r|³ r̂ × J r̂
//            − (3/2) J2 μ a² / |r|⁵ ((35 s² − 5) r̂ × J r̂ − 10 s (r̂ × J n + n × J r̂) + 2 n × J n)
//
// The gradient of each is a sum of dyads; of u vᵀ + v uᵀ the torque on a body with the inertia J is u × J v + v × J u.
//
// Where W's origin falls freely at o, the central term is the difference from the one there, in Battin's form (An
// Introduction to the Mathematics and Methods of Astrodynamics, 8.4), in which nothing cancels:
//
//   −μ / |o|³ (p − F r),   q = p·(p + 2 o) / |o|²,   F = q (3 + 3 q + q²) / ((1 + q)^1.5 ((1 + q)^1.5 + 1))
#pragma once

#include "kernel/environment/planet.h"

namespace unlatch {

// Free fall at the point p, as W sees it; W, m/s². W's origin is at o from the centre: OriginMotion::r at the time.
Vec3 calc_planet_gravity(const PlanPlanet& planet, const Vec3& o, const Vec3& p) noexcept;

// On a body with the inertia J about its centre of mass at p; world axes, N m.
Vec3 calc_gradient_torque(const PlanPlanet& planet, const Vec3& o, const Vec3& p, const Sym3& J) noexcept;

}  // namespace unlatch
