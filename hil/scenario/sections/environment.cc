// Sections `environment` and `start`: the planet, its air and wind, and a start from a point of a trajectory.
#include <cmath>
#include <numbers>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/sections/scenario_reader.h"
#include "hil/scenario/text/number_text.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

// A word, for keys that take a word or a mapping.
bool is_word(const YamlNode& node) { return node.is_scalar(); }

}  // namespace

void ScenarioReader::read_environment(YamlMap& top) {
  const YamlNode* node = top.find("environment");
  if (!node) return;
  read_item_at("environment", *node, [&] {
    YamlMap map(*node, "environment", mistakes_);
    Environment& environment = model_.environment;
    if (const YamlNode* planet = map.require("planet")) read_planet(*planet);
    const bool gradient = map.boolean("gradient_torque", true);
    if (environment.planet) environment.planet->gradient_torque = gradient;
    static const std::vector<std::string> kOrigins{"centre", "start", "falling"};
    origin_ = static_cast<Start::Origin>(std::max(0, map.choice("origin", "origin", kOrigins, 0)));
    origin_node_ = map.find("origin");
    if (const YamlNode* atmosphere = map.find("atmosphere")) read_atmosphere(*atmosphere);
    if (const YamlNode* wind = map.find("wind")) read_wind(*wind);
    if (const YamlNode* launch = map.find("launch")) {
      YamlMap site(*launch, "launch", mistakes_);
      environment.launch.latitude = site.number("latitude", "rad", 0.0);
      environment.launch.longitude = site.number("longitude", "rad", 0.0);
      environment.launch.altitude = site.number("altitude", "m", 0.0);
      environment.launch.azimuth = site.number("azimuth", "rad", 0.0);
      site.finish();
    }
    map.finish();
  });
}

void ScenarioReader::read_planet(const YamlNode& node) {
  Planet planet;
  if (is_word(node)) {
    read_choice(node, "planet", {"wgs84"}, mistakes_);
    model_.environment.planet = planet;
    return;
  }
  YamlMap map(node, "planet", mistakes_);
  planet.radius = read_bounded(map, get_number_key("scenario.planet.radius"), planet.radius, mistakes_);
  planet.flattening = read_bounded(map, get_number_key("scenario.planet.flattening"), planet.flattening, mistakes_);
  planet.mu = read_bounded(map, get_number_key("scenario.planet.mu"), planet.mu, mistakes_);
  planet.j2 = map.number("j2", "", planet.j2);
  planet.rate = map.number("rate", "rad/s", planet.rate);
  planet.meridian = map.number("meridian", "rad", planet.meridian);
  if (map.find("pole")) planet.pole = read_direction(map, "pole", true);
  map.finish();
  model_.environment.planet = planet;
}

void ScenarioReader::read_atmosphere(const YamlNode& node) {
  Atmosphere air;
  if (is_word(node)) {
    read_choice(node, "atmosphere", {"us1976"}, mistakes_);
  } else {
    air.kind = Atmosphere::Kind::kTable;
    YamlMap map(node, "atmosphere", mistakes_);
    if (const YamlNode* list = map.require("altitude")) air.altitudes = read_numbers(*list, 0, "m", mistakes_);
    if (const YamlNode* list = map.require("density")) air.densities = read_numbers(*list, 0, "kg/m3", mistakes_);
    if (const YamlNode* list = map.require("pressure")) air.pressures = read_numbers(*list, 0, "Pa", mistakes_);
    map.finish();
  }
  model_.environment.atmosphere = std::move(air);
}

void ScenarioReader::read_wind(const YamlNode& node) {
  Wind wind;
  if (node.is_sequence()) {
    wind.altitudes = {0};
    wind.velocities = {read_vector(node, "m/s", Eigen::Vector3d::Zero(), mistakes_)};
    if (wind.velocities[0].isZero(0)) return;
  } else {
    YamlMap map(node, "wind", mistakes_);
    if (const YamlNode* list = map.require("altitude")) wind.altitudes = read_numbers(*list, 0, "m", mistakes_);
    wind.velocities.assign(wind.altitudes.size(), Eigen::Vector3d::Zero());
    static const char* const kKeys[] = {"north", "east", "down"};
    for (int i = 0; i < 3; ++i) {
      const YamlNode* list = map.find(kKeys[i]);
      if (!list) continue;
      const std::vector<double> values = read_numbers(*list, wind.altitudes.size(), "m/s", mistakes_);
      for (std::size_t k = 0; k < wind.altitudes.size() && k < values.size(); ++k) wind.velocities[k][i] = values[k];
    }
    map.finish();
  }
  model_.environment.wind = std::move(wind);
}

// North, east, down.
Eigen::Vector3d ScenarioReader::read_start_velocity(const YamlNode& node) {
  if (!node.is_mapping()) return read_vector(node, "m/s", Eigen::Vector3d::Zero(), mistakes_);
  YamlMap map(node, "velocity", mistakes_);
  const double speed = map.number("speed", "m/s"), angle = map.number("flight_path_angle", "rad", 0.0),
               azimuth = map.number("azimuth", "rad", 0.0);
  map.finish();
  double rise, level, east, north;
  elementary::sincos(angle, rise, level);
  elementary::sincos(azimuth, east, north);
  return {speed * level * north, speed * level * east, -speed * rise};
}

// Facts that a user of this start should know: digits that W costs, and errors that grow.
void ScenarioReader::remark_start(const Start& start) {
  const Planet& planet = *model_.environment.planet;
  const Eigen::Vector3d place = calc_point(planet, {start.latitude, start.longitude, start.altitude});
  const double radius = place.norm();
  if (start.origin == Start::Origin::kKept && model_.bodies.size() > 1)
    scenario_.remarks.push_back({"start",
                                 "places in W are numbers of " + write_short(radius) + " m, which have steps of " +
                                     write_short(std::nextafter(radius, 2 * radius) - radius) +
                                     " m: environment.origin: start, or falling in orbit, keeps more digits of what "
                                     "bodies are to each other",
                                 "digits"});
  Eigen::Vector3d v = start.velocity;
  if (!start.inertial) v.y() += planet.rate * std::hypot(place.x(), place.y());
  const double inverse_axis = 2 / radius - v.squaredNorm() / planet.mu;  // vis viva
  if (!(planet.mu > 0) || !(inverse_axis > 0)) return;
  const double period = 2 * std::numbers::pi / std::sqrt(planet.mu * inverse_axis * inverse_axis * inverse_axis);
  constexpr double kPart = 0.2, kError = 1e-3;                          // of a revolution; m/s
  if (scenario_.until > kPart * period && radius * inverse_axis < 1.9)  // 2: it falls straight down
    scenario_.remarks.push_back({"start",
                                 "the run lasts " + write_short(scenario_.until / period) +
                                     " revolutions: an error of 1 mm/s along the motion grows to " +
                                     write_short(3 * kError * scenario_.until) + " m",
                                 "sensitivity"});
}

void ScenarioReader::read_start(YamlMap& top) {
  const YamlNode* node = top.find("start");
  if (!node) {
    if (origin_ != Start::Origin::kKept && origin_node_)
      mistakes_.add(origin_node_->mark, "W's origin is at the start, and there is no `start`",
                    "write `start:`, or origin: centre");
    return;
  }
  read_item_at("start", *node, [&] {
    YamlMap map(*node, "start", mistakes_);
    Start start;
    start.origin = origin_;
    start.latitude = map.number("latitude", "rad", 0.0);
    start.longitude = map.number("longitude", "rad", 0.0);
    start.altitude = map.number("altitude", "m", 0.0);
    if (const YamlNode* velocity = map.find("velocity")) start.velocity = read_start_velocity(*velocity);
    start.inertial = map.choice("relative_to", "frame", {"planet", "inertial"}, 0) == 1;
    if (const YamlNode* attitude = map.find("attitude"); attitude && is_word(*attitude)) {
      read_choice(*attitude, "attitude", {"along_velocity"}, mistakes_);
    } else if (attitude) {
      YamlMap angles(*attitude, "attitude", mistakes_);
      const double roll = angles.number("roll", "rad", 0.0), pitch = angles.number("pitch", "rad", 0.0);
      start.euler = {roll, pitch, angles.number("yaw", "rad", 0.0)};
      angles.finish();
    }
    start.rate = map.vector("rate", "rad/s", Eigen::Vector3d::Zero());
    static const std::vector<std::string> kFrames{"inertial", "planet", "local"};
    start.turns = static_cast<Start::Turns>(std::max(0, map.choice("rate_relative_to", "frame", kFrames, 0)));
    std::vector<std::string> frames = bodies_;
    frames.push_back("ground");
    const int body = map.choice("body", "body", frames, static_cast<int>(bodies_.size()));
    start.body = body == static_cast<int>(bodies_.size()) ? kGround : body;
    map.finish();
    if (!model_.environment.planet)
      return mistakes_.add(node->mark, "a start in flight, and no planet", "environment: {planet: wgs84}");
    if (start.body != kGround && model_.bodies[static_cast<std::size_t>(std::max(0, start.body))].marker)
      mistakes_.add(node->mark, "it puts a marker at the start", "name the marker's flexible body");
    if (mistakes_.count() > 0) return;
    remark_start(start);
    model_ = place_start(model_, start);
  });
}

}  // namespace unlatch::hil
