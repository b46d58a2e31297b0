// The part of the environment that checks and compiles, and may allocate.
#include "kernel/environment/environment_model.h"

#include <algorithm>
#include <cmath>

#include "kernel/model/from_eigen.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// --- The standard's numbers ------------------------------------------------------------------------------------------

struct LayerStart {
  double base, lapse;  // geopotential km, K/km
};
constexpr LayerStart kLayers[] = {{0, -6.5}, {11, 0}, {20, 1}, {32, 2.8}, {47, 0}, {51, -2.8}, {71, -2}};
constexpr double kSeaTemperature = 288.15, kSeaPressure = 101325;  // K, Pa
constexpr double kTop = 86;                                        // km, where the layers end

// Published values above 86 km: US Standard Atmosphere 1976, table I.
struct UpperRow {
  double altitude, pressure, density;  // km, Pa, kg/m³
};
constexpr UpperRow kUpper[] = {
    {90, 1.8359e-1, 3.416e-6},   {95, 7.5966e-2, 1.393e-6},   {100, 3.2011e-2, 5.604e-7},  {105, 1.4477e-2, 2.325e-7},
    {110, 7.1042e-3, 9.708e-8},  {115, 4.0096e-3, 4.289e-8},  {120, 2.5382e-3, 2.222e-8},  {125, 1.7354e-3, 1.291e-8},
    {130, 1.2505e-3, 8.152e-9},  {140, 7.2028e-4, 3.831e-9},  {150, 4.5422e-4, 2.076e-9},  {160, 3.0395e-4, 1.233e-9},
    {180, 1.5271e-4, 5.194e-10}, {200, 8.4736e-5, 2.541e-10}, {250, 2.4767e-5, 6.073e-11}, {300, 8.7704e-6, 1.916e-11},
    {350, 3.4498e-6, 7.014e-12}, {400, 1.4518e-6, 2.803e-12}, {450, 6.4468e-7, 1.184e-12}, {500, 3.0236e-7, 5.215e-13},
    {600, 8.2130e-8, 1.137e-13}, {700, 3.1908e-8, 3.070e-14}, {800, 1.7036e-8, 1.136e-14}, {900, 1.0873e-8, 5.759e-15},
    {1000, 7.5138e-9, 3.561e-15}};

// Temperature and pressure at the bases of the layers, each by the layer below it.
void build_layers(std::vector<AirLayer>& layers) {
  double temperature = kSeaTemperature, pressure = kSeaPressure;
  for (const LayerStart& start : kLayers) {
    if (!layers.empty()) {
      const AirLayer& below = layers.back();
      temperature = below.temperature + below.lapse * (start.base * 1000 - below.base);
      pressure = calc_layer_pressure(below, start.base * 1000, temperature);
    }
    layers.push_back({start.base * 1000, temperature, start.lapse / 1000, pressure});
  }
}

// Slope at knot i of the parabola through it and its neighbours; at an end that of the parabola through the last three.
double calc_slope(const std::vector<AirKnot>& knots, std::size_t i, double AirKnot::*value) {
  const std::size_t last = knots.size() - 1;
  const auto rise = [&](std::size_t k) {
    return (knots[k + 1].*value - knots[k].*value) / (knots[k + 1].altitude - knots[k].altitude);
  };
  if (last == 1) return rise(0);
  const std::size_t middle = std::clamp<std::size_t>(i, 1, last - 1);
  const double before = knots[middle].altitude - knots[middle - 1].altitude,
               after = knots[middle + 1].altitude - knots[middle].altitude;
  const double low = rise(middle - 1), high = rise(middle), bend = (high - low) / (before + after);
  if (i == 0) return low - bend * before;
  return i == last ? high + bend * after : low + bend * before;
}

void build_slopes(std::vector<AirKnot>& knots) {
  for (std::size_t i = 0; i < knots.size(); ++i) {
    knots[i].density_slope = calc_slope(knots, i, &AirKnot::density);
    knots[i].pressure_slope = calc_slope(knots, i, &AirKnot::pressure);
  }
}

AirKnot build_knot(double altitude, double density, double pressure) {
  return {altitude, elementary::log(density), elementary::log(pressure), 0, 0};
}

// Layers and knots of an atmosphere.
void compile_air(const Atmosphere& atmosphere, std::vector<AirLayer>& layers, std::vector<AirKnot>& knots) {
  if (atmosphere.kind == Atmosphere::Kind::kStandard) {
    build_layers(layers);
    const AirState top = calc_air(AirView{layers, {}}, kTop * 1000);
    knots.push_back(build_knot(kTop * 1000, top.density, top.pressure));
    for (const UpperRow& row : kUpper) knots.push_back(build_knot(row.altitude * 1000, row.density, row.pressure));
  } else {
    for (std::size_t i = 0; i < atmosphere.altitudes.size(); ++i)
      knots.push_back(build_knot(atmosphere.altitudes[i], atmosphere.densities[i], atmosphere.pressures[i]));
  }
  build_slopes(knots);
}

// Where the air has a corner: at the borders of the layers, where the lowest air begins to hold, and in the wind's
// rows.
std::vector<double> list_corners(const CompiledEnvironment& compiled) {
  std::vector<double> list;
  if (!compiled.layers.empty()) {
    list.push_back(kLowestAir);
    for (std::size_t i = 1; i < compiled.layers.size(); ++i)
      list.push_back(calc_geometric_altitude(compiled.layers[i].base));
  }
  if (!compiled.air.empty()) list.push_back(compiled.air.front().altitude);  // that of the top of the layers
  for (const WindKnot& knot : compiled.wind) list.push_back(knot.altitude);
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

// --- Mistakes --------------------------------------------------------------------------------------------------------

void check_planet(const Planet& planet, const Check& check) {
  check.check_positive("radius", planet.radius);
  check.check_not_negative("mu", planet.mu);
  check.check_finite("j2", std::isfinite(planet.j2));
  check.check_finite("rate", std::isfinite(planet.rate));
  check.check_finite("meridian", std::isfinite(planet.meridian));
  check.check_finite("centre", planet.centre.allFinite());
  check.check_finite("velocity", planet.velocity.allFinite());
  if (!(planet.flattening >= 0 && planet.flattening < 1))
    check.report("flattening is " + show(planet.flattening), "(a - b) / a: from 0 to below 1", "flattening");
  check.check_unit("pole", planet.pole);
}

void check_fall(const Model& model, const Planet& planet, const Check& check) {
  const double r = planet.centre.norm(), v2 = planet.velocity.squaredNorm();
  const double moment = planet.centre.cross(planet.velocity).norm();
  if (!(planet.mu > 0) || !(r > 0) || !(moment > 0) || !(0.5 * v2 < planet.mu / r))
    check.report("the origin that falls follows no ellipse",
                 "a start slower than escape, with some speed across the vertical; or another origin", "origin");
  for (const Joint& joint : model.joints)
    if (joint.base == kGround &&
        std::any_of(joint.modes.begin(), joint.modes.end(), [](const JointMode& mode) { return mode.rows != 0; }))
      check.report("joint '" + joint.name + "' holds a body to W, whose origin falls freely",
                   "an origin that rests: centre or start", "origin");
}

bool is_rising(const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]) || (i > 0 && !(values[i] > values[i - 1]))) return false;
  return true;
}

void check_atmosphere(const Atmosphere& air, const Check& check) {
  if (air.kind == Atmosphere::Kind::kStandard) return;
  const std::size_t count = air.altitudes.size();
  if (count < 2 || air.densities.size() != count || air.pressures.size() != count)
    return check.report("the numbers of altitudes, densities and pressures of its table are " + std::to_string(count) +
                            ", " + std::to_string(air.densities.size()) + " and " +
                            std::to_string(air.pressures.size()),
                        "as many of each, at least two", "atmosphere");
  if (!is_rising(air.altitudes))
    check.report("its altitudes do not rise", "each higher than the one before", "atmosphere");
  for (const std::vector<double>* list : {&air.densities, &air.pressures})
    for (const double value : *list)
      if (!(value > 1e-300) || !std::isfinite(value))
        return check.report("a density or pressure is " + show(value), "greater than 0, and finite", "atmosphere");
}

void check_wind(const Wind& wind, const Check& check) {
  if (wind.altitudes.empty() || wind.velocities.size() != wind.altitudes.size())
    check.report("the numbers of altitudes and velocities of its wind are " + std::to_string(wind.altitudes.size()) +
                     " and " + std::to_string(wind.velocities.size()),
                 "as many of each, at least one", "wind");
  if (!is_rising(wind.altitudes))
    check.report("the altitudes of its wind do not rise", "each higher than the one before", "wind");
  for (const Eigen::Vector3d& velocity : wind.velocities) check.check_finite("wind", velocity.allFinite());
}

}  // namespace

PlanPlanet compile_planet(const Planet& planet) {
  PlanPlanet out;
  out.radius = planet.radius;
  out.flattening = planet.flattening;
  out.mu = planet.mu;
  out.j2 = planet.j2;
  out.rate = planet.rate;
  out.meridian = planet.meridian;
  out.gradient_torque = planet.gradient_torque;
  constexpr double kAlong = 0.999;  // cosine beyond which x of W is no direction across the pole
  const Vec3 z = to_vec(planet.pole), start = std::abs(z.x) < kAlong ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 across = start - dot(start, z) * z;
  const Vec3 x = (1 / norm(across)) * across;
  out.axes = {x, cross(z, x), z};
  out.origin = -to_vec(planet.centre);
  out.falling = planet.falling;
  if (!planet.falling) return out;
  out.velocity = to_vec(planet.velocity);
  const double r = norm(out.origin), v2 = dot(out.velocity, out.velocity);
  out.distance = r;
  out.semi_major = 1 / (2 / r - v2 / planet.mu);
  out.mean_motion = std::sqrt(planet.mu / out.semi_major) / out.semi_major;
  out.e_cosine = 1 - r / out.semi_major;
  out.e_sine = dot(out.origin, out.velocity) / std::sqrt(planet.mu * out.semi_major);
  return out;
}

CompiledEnvironment compile_environment(const Environment& environment) {
  CompiledEnvironment compiled;
  if (!environment.planet) return compiled;
  PlanEnvironment& out = compiled.numbers;
  out.exists = true;
  out.planet = compile_planet(*environment.planet);
  out.has_air = environment.atmosphere.has_value();
  if (out.has_air) compile_air(*environment.atmosphere, compiled.layers, compiled.air);
  if (environment.wind)
    for (std::size_t i = 0; i < environment.wind->altitudes.size(); ++i)
      compiled.wind.push_back({environment.wind->altitudes[i], to_vec(environment.wind->velocities[i])});
  compiled.corners = list_corners(compiled);
  const LaunchSite& launch = environment.launch;
  const PlanetPlace place = place_at(out.planet, launch.latitude, launch.longitude, launch.altitude);
  double sine, cosine;
  elementary::sincos(launch.azimuth, sine, cosine);
  out.launch_point = place.r;
  const Mat3& axes = place.axes;
  out.launch_axes = {cosine * axes.x + sine * axes.y, cosine * axes.y - sine * axes.x, axes.z};
  return compiled;
}

void validate_environment(const Model& model, ModelErrors& errors) {
  const Environment& environment = model.environment;
  const Check check{model, "environment", errors};
  const LaunchSite& launch = environment.launch;
  check.check_finite("launch", std::isfinite(launch.latitude + launch.longitude + launch.altitude + launch.azimuth));
  if (!environment.planet) {
    if (environment.atmosphere || environment.wind)
      check.report("there is air, and no planet", "name a planet: planet: wgs84", "planet");
    return;
  }
  const std::size_t before = errors.size();
  check_planet(*environment.planet, check);
  if (errors.size() == before && environment.planet->falling) check_fall(model, *environment.planet, check);
  if (model.gravity.mu > 0 && environment.planet->mu > 0)
    check.report("there are two central fields: the planet's and that of `gravity`", "leave gravity.mu out", "planet");
  if (environment.atmosphere) check_atmosphere(*environment.atmosphere, check);
  if (environment.wind) check_wind(*environment.wind, check);
}

AirState calc_air(const Atmosphere& atmosphere, double altitude) {
  std::vector<AirLayer> layers;
  std::vector<AirKnot> knots;
  compile_air(atmosphere, layers, knots);
  return calc_air(AirView{layers, knots}, altitude);
}

GeodeticPoint calc_geodetic(const Planet& planet, const Eigen::Vector3d& point) noexcept {
  const Vec3 r = to_vec(point);
  const Geodetic g = calc_geodetic(planet.radius, planet.flattening, std::sqrt(r.x * r.x + r.y * r.y), r.z);
  return {elementary::atan2(g.sine, g.cosine), elementary::atan2(r.y, r.x), g.altitude};
}

Eigen::Vector3d calc_point(const Planet& planet, const GeodeticPoint& point) noexcept {
  PlanPlanet own;
  own.radius = planet.radius;
  own.flattening = planet.flattening;
  const Vec3 r = place_at(own, point.latitude, point.longitude, point.altitude).r;
  return {r.x, r.y, r.z};
}

}  // namespace unlatch
