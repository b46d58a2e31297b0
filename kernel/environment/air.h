// Air over the altitude z: US Standard Atmosphere 1976 (NOAA-S/T 76-1562), or a table.
//
// Up to 86 km the standard has seven layers of the geopotential altitude H = r₀ z / (r₀ + z), in each of which the
// molecular-scale temperature T is linear and the pressure follows from hydrostatic balance. Beyond, to 1000 km, ln p
// and ln ρ are cubic Hermite polynomials of z between values that the standard publishes, with the slopes of the
// parabolas through three neighbours; above 1000 km they go on with their last slopes. Below −5 km the air of −5 km
// holds. Tables are read as the upper part is, and hold their first value below.
//
// Temperature is the molecular-scale one, T = M₀ p / (R* ρ), everywhere, and the speed of sound √(1.4 p / ρ): above
// 80 km the kinetic temperature is lower, since the air is lighter there.
#pragma once

#include <span>

#include "unlatch/math.h"
#include "unlatch/model/environment.h"

namespace unlatch {

// A knot of ln ρ and ln p, and their slopes there, 1/m.
struct AirKnot {
  double altitude, density, pressure;
  double density_slope, pressure_slope;
};
struct AirLayer {
  double base, temperature, lapse, pressure;  // geopotential, m; K; K/m; Pa
};
// Air of a plan.
struct AirView {
  std::span<const AirLayer> layers;  // of the standard; none of a table
  std::span<const AirKnot> knots;
};
inline constexpr double kLowestAir = -5000;  // m, of the standard
// m, of the geopotential altitude H.
double calc_geometric_altitude(double H) noexcept;
AirState calc_air(const AirView& air, double altitude) noexcept;
// At the geopotential altitude H, m, where the layer has this temperature.
double calc_layer_pressure(const AirLayer& layer, double H, double temperature) noexcept;

struct WindKnot {
  double altitude;
  Vec3 velocity;  // towards north, east, down, m/s
};
// Velocity of the air over the surface, north, east, down.
Vec3 calc_wind(std::span<const WindKnot> wind, double altitude) noexcept;

}  // namespace unlatch
