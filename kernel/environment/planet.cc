#include "kernel/environment/planet.h"

#include <algorithm>
#include <numbers>

#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// The change of the eccentric anomaly over a change of the mean one within ±π:
// E + e sin E₀ (1 − cos E) − e cos E₀ sin E = M, whose left side rises with the slope r / a.
double solve_kepler(const PlanPlanet& planet, double M) noexcept {
  const double p = planet.e_sine, q = planet.e_cosine, reach = 2 * std::sqrt(p * p + q * q);
  constexpr double kRounding = 4e-16;
  double low = M - reach, high = M + reach, E = M, sine, cosine;
  for (int i = 0; i < kKeplerSteps; ++i) {
    elementary::sincos(E, sine, cosine);
    const double rest = (E - M) + (p * (1 - cosine) - q * sine);
    double next = E - rest / (1 + (p * sine - q * cosine));
    if (std::abs(next - E) <= kRounding * (1 + std::abs(E))) return next;
    (rest > 0 ? high : low) = E;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    E = next;
  }
  return E;
}

PlanetPlace complete_place(const Vec3& r, const Geodetic& geodetic, double sine, double cosine) {
  const double s = geodetic.sine, c = geodetic.cosine;
  return {r, geodetic, sine, cosine, {{-s * cosine, -s * sine, c}, {-sine, cosine, 0}, {-c * cosine, -c * sine, -s}}};
}

}  // namespace

OriginMotion calc_origin(const PlanPlanet& planet, double t) noexcept {
  if (!planet.falling) return {planet.origin, planet.velocity};
  constexpr double kTurn = 2 * std::numbers::pi;
  const double n = planet.mean_motion, a = planet.semi_major, r0 = planet.distance;
  double M = n * t;
  M -= kTurn * std::floor(M / kTurn + 0.5);
  const double E = solve_kepler(planet, M);
  double sine, cosine;
  elementary::sincos(E, sine, cosine);
  double half_sine, half_cosine;
  elementary::sincos(0.5 * E, half_sine, half_cosine);
  const double versine = 2 * (half_sine * half_sine);  // 1 − cos E
  const double r = a * (1 + (planet.e_sine * sine - planet.e_cosine * cosine));
  const double f = 1 - a / r0 * versine, g = ((M - E) + sine) / n;
  const double f_rate = -(n * a) * (a / (r * r0)) * sine, g_rate = 1 - a / r * versine;
  return {f * planet.origin + g * planet.velocity, f_rate * planet.origin + g_rate * planet.velocity};
}

PlanetPlace calc_place(const PlanPlanet& planet, const Vec3& r) noexcept {
  const double rho = std::sqrt(r.x * r.x + r.y * r.y);
  const Geodetic geodetic = calc_geodetic(planet.radius, planet.flattening, rho, r.z);
  return rho > 0 ? complete_place(r, geodetic, r.y / rho, r.x / rho) : complete_place(r, geodetic, 0, 1);
}

PlanetPlace place_at(const PlanPlanet& planet, double latitude, double longitude, double altitude) noexcept {
  double s, c, sine, cosine;
  elementary::sincos(latitude, s, c);
  elementary::sincos(longitude, sine, cosine);
  const double e2 = planet.flattening * (2 - planet.flattening);
  const double normal = planet.radius / std::sqrt(1 - e2 * (s * s));  // to the pole's axis along the ellipsoid's normal
  const double rho = (normal + altitude) * c;
  return complete_place({rho * cosine, rho * sine, ((1 - e2) * normal + altitude) * s}, {s, c, altitude}, sine, cosine);
}

}  // namespace unlatch
