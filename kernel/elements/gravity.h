// Acceleration of free fall, m/s²: uniform, and of a central field −μ r / |r|³; of a planet, see
// kernel/environment/field.h.
#pragma once

#include <cmath>

#include "kernel/plan/plan_data.h"

namespace unlatch {

// At the point get_point(), W, which is called only if there is a central field.
template <class T, class GetPoint>
UNLATCH_INLINE Vec3T<T> calc_gravity(const GravityField& field, const GetPoint& get_point) {
  using std::sqrt;
  const Vec3T<T> uniform{T(field.uniform.x), T(field.uniform.y), T(field.uniform.z)};
  if (field.mu == 0) return uniform;
  const Vec3T<T> r = get_point() - Vec3T<T>{T(field.centre.x), T(field.centre.y), T(field.centre.z)};
  const T r2 = dot(r, r);
  return uniform - (T(field.mu) / (r2 * sqrt(r2))) * r;
}
inline Vec3 calc_gravity(const GravityField& field, const Vec3& p) {
  return calc_gravity<double>(field, [&] { return p; });
}

// Air and wind of a plan.
inline AirAround get_air(const PlanData& plan) { return {{plan.air_layers, plan.air_knots}, plan.wind_knots}; }

// W's origin from the planet's centre at the time t, m; zero without a planet. Falling, it takes Kepler's equation:
// once for all that is evaluated at that time.
inline Vec3 calc_origin_place(const PlanData& plan, double t) {
  return plan.environment.exists ? calc_origin(plan.environment.planet, t).r : Vec3{0, 0, 0};
}

// All of it, at the point p of W, whose origin is at calc_origin_place().
inline Vec3 calc_free_fall(const PlanData& plan, const Vec3& origin, const Vec3& p) {
  const Vec3 g = calc_gravity(plan.gravity, p);
  return plan.environment.exists ? g + calc_planet_gravity(plan.environment.planet, origin, p) : g;
}

}  // namespace unlatch
