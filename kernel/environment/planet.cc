#include "kernel/environment/planet.h"

#include <algorithm>
#include <numbers>

#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// An angle's sine and cosine.
struct Direction {
  double sine, cosine;
};
Direction add(const Direction& a, const Direction& b) {
  return {a.sine * b.cosine + a.cosine * b.sine, a.cosine * b.cosine - a.sine * b.sine};
}

constexpr double kEighth = std::numbers::pi / 4, kHalfRoot = std::numbers::sqrt2 / 2;
constexpr Direction kEighths[] = {{0, 1},  {kHalfRoot, kHalfRoot},   {1, 0},  {kHalfRoot, -kHalfRoot},
                                  {0, -1}, {-kHalfRoot, -kHalfRoot}, {-1, 0}, {-kHalfRoot, kHalfRoot}};

// The change E of the eccentric anomaly over the change M of the mean one.
struct Anomaly {
  Direction direction;  // of E
  double lead;          // M − E, rad
};

// E + p (1 − cos E) − q sin E = M with p = e sin E₀ and q = e cos E₀; the left side rises with the slope r / a. Solved
// for what E has beyond the eighth of a turn next to M, so that sines cost the same all along the orbit, by steps of
// the fourth order from three derivatives (Danby, Fundamentals of Celestial Mechanics, 6.6) within a bracket; by
// Newton's where the higher derivatives change the slope by more than a factor of two, as near the lowest point of long
// ellipses.
Anomaly solve_kepler(const PlanPlanet& planet, double M) noexcept {
  const double eighths = std::floor(M / kEighth + 0.5), own = M - eighths * kEighth;
  const Direction& whole = kEighths[static_cast<std::size_t>(eighths - 8 * std::floor(eighths / 8))];
  const double p = planet.e_sine, q = planet.e_cosine, reach = 2 * std::sqrt(p * p + q * q);
  double low = own - reach, high = own + reach, x = own;
  Direction now{};
  for (int i = 0; i < kKeplerSteps; ++i) {
    Direction beyond;
    elementary::sincos(x, beyond.sine, beyond.cosine);
    now = add(whole, beyond);
    const double rest = (x - own) + (p * (1 - now.cosine) - q * now.sine);
    const double second = p * now.cosine + q * now.sine, slope = 1 + (p * now.sine - q * now.cosine);
    const auto is_like_slope = [&](double mean) { return mean > 0.5 * slope && mean < 2 * slope; };
    const double newton = -rest / slope, third = slope + newton * second / 2, guess = -rest / third;
    const double fourth = slope + guess * (second / 2 + guess * (1 - slope) / 6);
    const double step = is_like_slope(third) && is_like_slope(fourth) ? -rest / fourth : newton;
    constexpr double kLastStep = 1e-6;  // rad: both its fourth power and its third one over six are below rounding
    if (std::abs(newton) <= kLastStep) return {add(now, {step, 1 - 0.5 * (step * step)}), (own - x) - step};
    (rest > 0 ? high : low) = x;
    x += step;
    if (!(x > low && x < high)) x = 0.5 * (low + high);
  }
  return {now, own - x};
}

PlanetPlace complete_place(const Vec3& r, const Geodetic& geodetic, double sine, double cosine) {
  const double s = geodetic.sine, c = geodetic.cosine;
  return {r, geodetic, sine, cosine, {{-s * cosine, -s * sine, c}, {-sine, cosine, 0}, {-c * cosine, -c * sine, -s}}};
}

}  // namespace

OriginMotion calc_origin(const PlanPlanet& planet, double t) noexcept {
  if (!planet.falling) return {planet.origin, planet.velocity};
  const double n = planet.mean_motion, a = planet.semi_major, r0 = planet.distance;
  const Anomaly anomaly = solve_kepler(planet, n * t);
  const auto [sine, cosine] = anomaly.direction;
  const double versine = cosine > 0 ? sine * sine / (1 + cosine) : 1 - cosine;  // 1 − cos E
  const double r = a * (1 + (planet.e_sine * sine - planet.e_cosine * cosine));
  const double f = 1 - a / r0 * versine, g = (anomaly.lead + sine) / n;
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
