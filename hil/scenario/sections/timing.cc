// Timing: the policy for overruns, and the rates of groups.
#include <algorithm>
#include <cmath>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {
namespace {

constexpr double kSameTime = 1e-6;  // relative to a step: the rounding of a decimal period

bool is_whole(double value) { return value == std::floor(value); }

}  // namespace

void ScenarioReader::read_timing(YamlMap& top) {
  const YamlNode* node = top.find("timing");
  if (!node) return;
  TimingOptions& timing = scenario_.timing;
  YamlMap map(*node, "timing", mistakes_);
  if (const YamlNode* overruns = map.find("overruns")) read_overruns(*overruns);
  timing.spin = read_bounded(map, get_number_key("scenario.timing.spin"), timing.spin, mistakes_);
  if (const YamlNode* watchdog = map.find("watchdog")) read_watchdog(*watchdog);
  timing.per_tick = map.boolean("per_tick", timing.per_tick);
  if (const YamlNode* states = map.find("states")) {
    YamlMap inner(*states, "states", mistakes_);
    scenario_.rates.states = read_rate(inner);
    inner.finish();
  }
  if (const YamlNode* groups = map.find("groups")) read_rate_groups(*groups);
  map.finish();
}

// Reads a policy's name, or {catch_up: ticks}.
void ScenarioReader::read_overruns(const YamlNode& node) {
  OverrunPolicy& policy = scenario_.timing.overruns;
  if (!node.is_mapping()) {
    const int kind = read_choice(node, "policy", {"fail", "catch_up", "slip", "skip_output"}, mistakes_);
    if (kind >= 0) policy.kind = static_cast<OverrunPolicy::Kind>(kind);
    return;
  }
  YamlMap map(node, "overruns", mistakes_);
  const double ticks = read_bounded(map, get_number_key("scenario.catch_up.catch_up"), {}, mistakes_);
  if (ticks > 0) policy = {OverrunPolicy::Kind::kCatchUp, static_cast<std::int64_t>(ticks)};
  map.finish();
}

// Reads a limit, or {limit, action}.
void ScenarioReader::read_watchdog(const YamlNode& node) {
  TimingOptions& timing = scenario_.timing;
  if (!node.is_mapping()) {
    timing.watchdog = read_number(node, "s", timing.watchdog, mistakes_);
    check_bounds(timing.watchdog, get_number_key("scenario.timing.watchdog"), node.mark, mistakes_);
  } else {
    YamlMap map(node, "watchdog", mistakes_);
    timing.watchdog = read_bounded(map, get_number_key("scenario.watchdog.limit"), timing.watchdog, mistakes_);
    timing.watchdog_aborts = map.choice("action", "action", {"report", "abort"}, 0) == 1;
    map.finish();
  }
}

// Reads {every: ticks} or {period: s}, and {phase: ticks}.
Rate ScenarioReader::read_rate(YamlMap& map) {
  Rate rate;
  const std::string kind = map.only_one_of({"every", "period"}, "a rate");
  if (kind.empty()) return rate;
  const SourceMark mark = map.node().find(kind)->mark;
  const bool timed = kind == "period";
  double every = map.number(kind, timed ? "s" : "");
  if (timed && scenario_.dt > 0) {
    const double ticks = every / scenario_.dt;
    every = std::abs(ticks - std::round(ticks)) <= kSameTime ? std::round(ticks) : 0;
  }
  const double phase = map.number("phase", "", 0.0);
  constexpr const NumberKey& kEvery = get_number_key("scenario.rate.every");
  if (timed && !kEvery.holds(every)) {
    mistakes_.add(mark, "this period is not a whole number of steps", "a multiple of step.dt");
    return rate;
  }
  if (!check_bounds(every, kEvery, mark, mistakes_)) return rate;
  if (!(phase >= 0 && phase < every && is_whole(phase))) {
    mistakes_.add(map.node().find("phase")->mark, "this phase is not usable",
                  "a whole number of ticks from 0, below the rate's own");
    return rate;
  }
  return {static_cast<std::int64_t>(every), static_cast<std::int64_t>(phase)};
}

void ScenarioReader::read_rate_groups(const YamlNode& node) {
  if (!node.is_mapping()) {
    mistakes_.add(node.mark, "groups is not a mapping", "write name: {every: 10, sensors: [gyro]}");
    return;
  }
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    RateGroup group;
    group.name = node.keys[i].text;
    if (!is_name(group.name))
      mistakes_.add(node.keys[i].mark, "'" + group.name + "' cannot be the name of a group",
                    describe_name_rule(group.name));
    if (node.find(group.name) != &node.items[i]) {
      mistakes_.add(node.keys[i].mark, "group '" + group.name + "' is there twice", "give it another name");
      continue;
    }
    YamlMap map(node.items[i], "group '" + group.name + "'", mistakes_);
    group.rate = read_rate(map);
    if (const YamlNode* elements = map.find("elements")) read_group_channels(*elements, group);
    if (const YamlNode* sensors = map.find("sensors")) read_group_sensors(*sensors, group);
    map.finish();
    scenario_.rates.groups.push_back(std::move(group));
  }
  check_channels_belong_to_one_group(node);
}

// Reads channels; an element that a channel drives stands for that channel.
void ScenarioReader::read_group_channels(const YamlNode& node, RateGroup& group) {
  if (!node.is_sequence()) mistakes_.add(node.mark, "elements is not a list", "write their names: [nozzle1, nozzle2]");
  for (const YamlNode& item : node.items) {
    const int element = read_choice(item, "element", elements_, mistakes_);
    if (element < 0) continue;
    const auto index = static_cast<std::size_t>(element);
    const int channel = index < model_.loads.size() ? model_.loads[index].channel : kNone;
    if (channel == kNone) {
      mistakes_.add(item.mark, "no channel drives element '" + item.text + "'",
                    "only elements with a channel have a rate; forces and springs act at every stage of every step");
    } else if (std::find(group.channels.begin(), group.channels.end(), channel) == group.channels.end()) {
      group.channels.push_back(channel);
    }
  }
}

void ScenarioReader::read_group_sensors(const YamlNode& node, RateGroup& group) {
  std::vector<std::string> names;
  for (const Sensor& sensor : model_.sensors) names.push_back(sensor.name);
  if (!node.is_sequence()) mistakes_.add(node.mark, "sensors is not a list", "write their names: [gyro]");
  for (const YamlNode& item : node.items) {
    const int sensor = read_choice(item, "sensor", names, mistakes_);
    if (sensor < 0) continue;
    for (const RateGroup& other : scenario_.rates.groups) {
      if (std::find(other.sensors.begin(), other.sensors.end(), sensor) != other.sensors.end())
        mistakes_.add(item.mark, "sensor '" + item.text + "' is in group '" + other.name + "' already",
                      "a sensor has one rate");
    }
    if (std::find(group.sensors.begin(), group.sensors.end(), sensor) == group.sensors.end())
      group.sensors.push_back(sensor);
  }
}

// Checks that each channel is latched at one rate: all elements that it drives must be in one group.
void ScenarioReader::check_channels_belong_to_one_group(const YamlNode& node) {
  std::vector<std::string> owner(model_.channels.size());
  for (const RateGroup& group : scenario_.rates.groups) {
    for (const int channel : group.channels) {
      std::string& name = owner[static_cast<std::size_t>(channel)];
      if (!name.empty())
        mistakes_.add(node.find(group.name)->mark,
                      "channel '" + channels_[static_cast<std::size_t>(channel)] + "' drives elements of the groups '" +
                          name + "' and '" + group.name + "'",
                      "give the elements channels of their own, or one rate");
      name = group.name;
    }
  }
}

}  // namespace unlatch::hil
