#include "kernel/environment/air.h"

#include <cmath>

#include "kernel/math/table.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

constexpr double kGravity = 9.80665;        // g₀', m/s²
constexpr double kEarth = 6356766;          // r₀, m
constexpr double kGas = 8314.32 / 28.9644;  // R* / M₀, J/(kg K)
constexpr double kHeats = 1.4;              // ratio of specific heats
constexpr double kTop = 86000;              // altitude where the layers end, m

AirState complete(double density, double pressure) {
  const double part = pressure / density;
  return {density, pressure, part / kGas, std::sqrt(kHeats * part)};
}

AirState calc_layered(std::span<const AirLayer> layers, double altitude) {
  const double z = altitude > kLowestAir ? altitude : kLowestAir, H = kEarth * z / (kEarth + z);
  std::size_t i = layers.size() - 1;
  while (i > 0 && H < layers[i].base) --i;
  const double temperature = layers[i].temperature + layers[i].lapse * (H - layers[i].base);
  const double pressure = calc_layer_pressure(layers[i], H, temperature);
  return complete(pressure / (kGas * temperature), pressure);
}

// The cubic that has the values a and b and the slopes there, over x from 0 to `width`.
double calc_cubic(double x, double width, double a, double a_slope, double b, double b_slope) {
  const double u = x / width, rise = (b - a) / width;
  return a + x * (a_slope + u * ((3 * rise - 2 * a_slope - b_slope) + u * ((a_slope + b_slope) - 2 * rise)));
}

AirState calc_tabled(std::span<const AirKnot> knots, double altitude) {
  const AirKnot &first = knots.front(), &last = knots.back();
  double density, pressure;
  if (altitude >= last.altitude) {
    const double x = altitude - last.altitude;
    density = last.density + last.density_slope * x;
    pressure = last.pressure + last.pressure_slope * x;
  } else if (altitude <= first.altitude) {
    density = first.density;
    pressure = first.pressure;
  } else {
    const std::size_t low = find_piece(knots.size(), altitude, [&](std::size_t i) { return knots[i].altitude; });
    const AirKnot &a = knots[low], &b = knots[low + 1];
    const double x = altitude - a.altitude, width = b.altitude - a.altitude;
    density = calc_cubic(x, width, a.density, a.density_slope, b.density, b.density_slope);
    pressure = calc_cubic(x, width, a.pressure, a.pressure_slope, b.pressure, b.pressure_slope);
  }
  return complete(elementary::exp(density), elementary::exp(pressure));
}

}  // namespace

double calc_geometric_altitude(double H) noexcept { return kEarth * H / (kEarth - H); }

double calc_layer_pressure(const AirLayer& layer, double H, double temperature) noexcept {
  const double rise = H - layer.base;
  if (layer.lapse == 0) return layer.pressure * elementary::exp(-kGravity * rise / (kGas * temperature));
  const double power = kGravity / (kGas * layer.lapse);
  return layer.pressure * elementary::exp(-power * elementary::log(temperature / layer.temperature));
}

AirState calc_air(const AirView& air, double altitude) noexcept {
  if (!air.layers.empty() && !(altitude > kTop)) return calc_layered(air.layers, altitude);
  return calc_tabled(air.knots, altitude);
}

Vec3 calc_wind(std::span<const WindKnot> wind, double altitude) noexcept {
  if (wind.empty()) return {0, 0, 0};
  if (!(altitude > wind.front().altitude)) return wind.front().velocity;
  if (altitude >= wind.back().altitude) return wind.back().velocity;
  const std::size_t low = find_piece(wind.size(), altitude, [&](std::size_t i) { return wind[i].altitude; });
  const WindKnot &a = wind[low], &b = wind[low + 1];
  return a.velocity + ((altitude - a.altitude) / (b.altitude - a.altitude)) * (b.velocity - a.velocity);
}

}  // namespace unlatch
