#include "hil/scenario/outputs.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <stdexcept>

#include "hil/scenario/scenario.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/text/wildcard.h"
#include "unlatch/quantities.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

using Kind = Output::Kind;

constexpr double kSameTime = 1e-6;  // relative to a step: the rounding of a decimal period
constexpr double kMaxEvery = 1e9;   // ticks

const std::vector<std::string> kAxes{"x", "y", "z"};

// The list under construction.
class List {
 public:
  List(const Scenario& scenario, SensorsShown shown) : scenario_(scenario), model_(scenario.model) {
    for (std::size_t i = 0; i < model_.bodies.size(); ++i) add_body(i);
    for (std::size_t i = 0; i < model_.joints.size(); ++i) add_joint(i);
    add_elements();
    for (std::size_t i = 0; i < model_.sensors.size(); ++i) add_sensor(i, Kind::kSensor, "sensor");
    for (std::size_t i = 0; i < model_.signals.size(); ++i)
      add_plain(Kind::kSignal, i, "signal", model_.signals[i], {{"signal." + model_.signals[i], "1"}});
    for (std::size_t i = 0; i < model_.channels.size(); ++i) {
      const Channel& channel = model_.channels[i];
      const std::string unit = channel.unit.empty() ? "1" : channel.unit;
      add_plain(Kind::kCommand, i, "command", channel.name, {{"channel." + channel.name, unit}});
    }
    for (std::size_t i = 0; i < scenario_.clearance.size(); ++i) {
      const std::string pair = scenario_.clearance[i].a.name + "." + scenario_.clearance[i].b.name;
      add_plain(Kind::kClearance, i, "clearance", pair, {{"clearance." + pair, "m"}});
    }
    for (std::size_t i = 0; i < scenario_.named_quantities; ++i) {
      const unlatch::Quantity& quantity = model_.quantities[i];
      add_plain(Kind::kQuantity, i, "quantity", quantity.name,
                {{"quantity." + quantity.name, unlatch::get_unit(model_, quantity)}});
    }
    for (std::size_t i = 0; i < model_.sensors.size() && shows_received(scenario, shown); ++i)
      add_sensor(i, Kind::kReceived, "received");
  }
  std::vector<Output> outputs;

 private:
  struct Subject {
    const char* group;
    const std::string& name;
    std::size_t number;
  };

  // `columns`: the part of the names after the subject's name.
  void add(Kind kind, const Subject& of, const char* what, const char* key, const char* frame, const char* unit,
           const std::vector<std::string>& columns) {
    Output output;
    output.name = std::string(of.group) + "." + of.name + "." + what;
    output.what = what;
    output.key = key;
    output.frame = frame;
    for (const std::string& column : columns) output.columns.push_back({of.name + "." + column, unit});
    put(kind, of, std::move(output));
  }

  void add_plain(Kind kind, std::size_t number, const char* group, const std::string& name,
                 std::vector<Output::Column> columns) {
    Output output;
    output.name = std::string(group) + "." + name;
    output.columns = std::move(columns);
    put(kind, {group, name, number}, std::move(output));
  }

  void put(Kind kind, const Subject& of, Output output) {
    output.kind = kind;
    output.subject = static_cast<int>(of.number);
    output.group = of.group;
    output.of = of.name;
    output.first = values_;
    values_ += output.columns.size();
    // If a body and a joint have the same name, the second one is prefixed by its group.
    for (Output::Column& column : output.columns)
      while (!names_.insert(column.name).second) column.name = std::string(of.group) + "." + column.name;
    outputs.push_back(std::move(output));
  }

  void add_body(std::size_t number) {
    const Body& body = model_.bodies[number];
    const Subject of{"body", body.name, number};
    add(Kind::kPosition, of, "position", "p", "W", "m", kAxes);
    add(Kind::kAttitude, of, "attitude", "q", "W", "1", {"qw", "qx", "qy", "qz"});
    add(Kind::kVelocity, of, "velocity", "v", "W", "m/s", {"vx", "vy", "vz"});
    add(Kind::kRate, of, "rate", "w", "body", "rad/s", {"wx", "wy", "wz"});
    add(Kind::kAcceleration, of, "acceleration", "a", "W", "m/s2", {"ax", "ay", "az"});
    add(Kind::kAngularAcceleration, of, "angular_acceleration", "alpha", "body", "rad/s2",
        {"alphax", "alphay", "alphaz"});
    if (!body.flexible) return;
    std::vector<std::string> modal, rates;
    for (Eigen::Index k = 1; k <= body.flexible->frequencies.size(); ++k) {
      modal.push_back("modal" + std::to_string(k));
      rates.push_back("modal_rate" + std::to_string(k));
    }
    add(Kind::kModal, of, "modal", "modal", "", "kg^0.5 m", modal);
    add(Kind::kModalRate, of, "modal_rate", "modal_rate", "", "kg^0.5 m/s", rates);
  }

  void add_joint(std::size_t number) {
    const Subject of{"joint", model_.joints[number].name, number};
    const auto under = [](const std::string& what) {
      return std::vector<std::string>{what + ".x", what + ".y", what + ".z"};
    };
    add(Kind::kMode, of, "mode", "mode", "", "1", {"mode"});
    add(Kind::kForce, of, "force", "force", "joint", "N", kAxes);
    add(Kind::kMoment, of, "moment", "moment", "joint", "N m", {"rot_x", "rot_y", "rot_z"});
    add(Kind::kDisplacement, of, "displacement", "displacement", "joint", "m", under("displacement"));
    add(Kind::kAngle, of, "angle", "angle", "joint", "rad", under("angle"));
    add(Kind::kSpeed, of, "speed", "speed", "joint", "m/s", under("speed"));
    add(Kind::kAngleRate, of, "angle_rate", "angle_rate", "joint", "rad/s", under("angle_rate"));
  }

  void add_force(const Subject& of, bool angular) {
    const char* const what = angular ? "moment" : "force";
    add(Kind::kElementForce, of, what, what, "", angular ? "N m" : "N", {what});
  }
  void add_coordinate(const Subject& of, bool angular) {
    const char* const what = angular ? "angle" : "displacement";
    add(Kind::kElementCoordinate, of, what, what, "", angular ? "rad" : "m", {what});
    add(Kind::kElementRate, of, "rate", "rate", "", angular ? "rad/s" : "m/s", {"rate"});
  }

  void add_contact(const Subject& of) {
    add(Kind::kContactForce, of, "force", "force", "", "N", {"force"});
    add(Kind::kContactFriction, of, "friction", "friction", "", "N", {"friction"});
    add(Kind::kContactDepth, of, "depth", "depth", "", "m", {"depth"});
    add(Kind::kContactSlipSpeed, of, "slip_speed", "slip_speed", "", "m/s", {"slip_speed"});
    add(Kind::kContactImpulse, of, "impulse", "impulse", "", "N s", {"impulse"});
    add(Kind::kContactSlip, of, "slip", "slip", "", "m", {"slip"});
    add(Kind::kContactDissipated, of, "dissipated", "dissipated", "", "J", {"dissipated"});
  }

  // Adds elements, numbered like State::elements.
  void add_elements() {
    std::size_t contacts = 0;
    for (int number = 0; number < model_.element_count(); ++number) {
      const ElementTraits traits = describe_element(model_, number);
      const Subject of{"element", model_.element_name(number), static_cast<std::size_t>(number)};
      if (traits.is_contact)
        add_contact({of.group, of.name, contacts++});
      else
        add_readings(of, traits);
      add(Kind::kElementScale, of, "scale", "scale", "", "1", {"scale"});
    }
  }

  void add_readings(const Subject& of, const ElementTraits& traits) {
    add_force(of, traits.angular);
    const char* const length_unit = traits.angular ? "rad" : "m";
    if (traits.has_points) {
      add(Kind::kElementLength, of, "length", "length", "", "m", {"length"});
      add(Kind::kElementStroke, of, "stroke", "stroke", "", "m", {"stroke"});
      add(Kind::kElementRate, of, "rate", "rate", "", "m/s", {"rate"});
      return;
    }
    if (traits.has_coordinate) add_coordinate(of, traits.angular);
    if (traits.has_stroke) add(Kind::kElementStroke, of, "stroke", "stroke", "", length_unit, {"stroke"});
    if (traits.has_drum) {
      add(Kind::kElementWound, of, "wound", "wound", "", "rad", {"wound"});
      add(Kind::kElementOnDrum, of, "on_drum", "on_drum", "", "m", {"on_drum"});
    }
  }

  void add_sensor(std::size_t number, Kind kind, const char* group) {
    const Sensor& sensor = model_.sensors[number];
    std::vector<Output::Column> columns;
    unlatch::Quantity quantity = get_quantity(model_, sensor);
    const bool whole = quantity.part == unlatch::Quantity::kAll;
    const std::span<const char* const> components = get_sensor_components(sensor.kind);
    for (std::size_t k = 0; k < components.size(); ++k) {
      if (whole) quantity.part = static_cast<int>(k);
      columns.push_back({std::string(group) + "." + sensor.name + components[k], unlatch::get_unit(model_, quantity)});
    }
    add_plain(kind, number, group, sensor.name, std::move(columns));
    outputs.back().frame = get_traits(quantity.kind).frame;
  }

  const Scenario& scenario_;
  const Model& model_;
  std::size_t values_ = 0;
  std::set<std::string> names_{"tick", "t", "events"};
};

std::string_view without_group(const std::string& name) { return std::string_view(name).substr(name.find('.') + 1); }

// Reads ticks, or a rate in Hz.
std::int64_t parse_every(const std::string& item, std::string_view text, double dt) {
  const bool timed = text.ends_with("Hz");
  if (timed) text.remove_suffix(2);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  double number = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size())
    throw std::invalid_argument("'" + item + "': after @ stands a number of ticks, or a rate in Hz: @10, @100Hz");
  const bool whole = number >= 1 && number <= kMaxEvery && number == std::floor(number);
  const std::int64_t every = timed ? calc_every(number, dt) : whole ? static_cast<std::int64_t>(number) : 0;
  if (every < 1)
    throw std::invalid_argument("'" + item + "': " +
                                (timed ? "a period of this rate is not a whole number of steps; write a rate that "
                                         "divides 1/dt, or the ticks: @10"
                                       : "a whole number of ticks from 1"));
  return every;
}

}  // namespace

bool shows_received(const Scenario& scenario, SensorsShown shown) {
  const auto has_sensors = [](const RateGroup& group) { return !group.sensors.empty(); };
  return shown == SensorsShown::kAlsoReceived || !scenario.rates.errors.sensors.empty() ||
         std::ranges::any_of(scenario.rates.groups, has_sensors);
}

std::vector<Output> list_outputs(const Scenario& scenario, SensorsShown shown) { return List(scenario, shown).outputs; }

std::size_t count_values(std::span<const Output> outputs) {
  return outputs.empty() ? 0 : outputs.back().first + outputs.back().columns.size();
}

std::span<const char* const> get_sensor_components(Sensor::Kind kind) {
  static constexpr const char* kVector[] = {".x", ".y", ".z"};
  static constexpr const char* kQuaternion[] = {".w", ".x", ".y", ".z"};
  static constexpr const char* kRowValues[] = {".x", ".y", ".z", ".rot_x", ".rot_y", ".rot_z"};
  static constexpr const char* kScalar[] = {""};
  switch (sensor_width(kind)) {
    case 3:
      return kVector;
    case 4:
      return kQuaternion;
    case 6:
      return kRowValues;
    default:
      return kScalar;
  }
}

bool matches(std::string_view pattern, const Output& output) {
  return matches_text(pattern, output.name) || matches_text(pattern, without_group(output.name));
}

std::vector<SelectedOutputs> select_all(std::span<const Output> outputs, Rate rate) {
  std::vector<SelectedOutputs> all{{rate, {}}};
  for (std::size_t i = 0; i < outputs.size(); ++i) all[0].outputs.push_back(i);
  return all;
}

std::vector<SelectedOutputs> select(std::span<const Output> outputs, std::span<const OutputGroup> groups) {
  std::vector<SelectedOutputs> selected;
  for (const OutputGroup& group : groups) {
    SelectedOutputs& to = selected.emplace_back();
    to.rate = group.rate;
    for (std::size_t i = 0; i < outputs.size(); ++i)
      if (std::ranges::any_of(group.patterns, [&](const std::string& p) { return matches(p, outputs[i]); }))
        to.outputs.push_back(i);
  }
  return selected;
}

std::string find_fault(std::string_view pattern, std::span<const Output> outputs) {
  if (std::ranges::any_of(outputs, [&](const Output& output) { return matches(pattern, output); })) return {};
  std::vector<std::string> names;
  for (const Output& output : outputs) {
    if (std::ranges::any_of(output.columns, [&](const Output::Column& column) { return column.name == pattern; }))
      return "that is a column of '" + output.name + "': write that";
    names.push_back(output.name);
    names.emplace_back(without_group(output.name));
  }
  constexpr std::size_t kTypingErrors = 4;
  const std::string* const nearest = find_nearest(std::string(pattern), names, kTypingErrors);
  return (nearest == nullptr ? std::string() : "did you mean '" + *nearest + "'? ") +
         "known names are those of `unlatch check --outputs`; * stands for any characters";
}

std::vector<OutputGroup> parse_outputs(const std::string& text, double dt, std::span<const Output> outputs) {
  std::vector<OutputGroup> groups;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(',', from), text.size());
    const std::string item = text.substr(from, end - from);
    from = end + 1;
    const std::size_t at = item.find('@');
    const std::string pattern = item.substr(0, at);
    if (const std::string fault = find_fault(pattern, outputs); !fault.empty())
      throw std::invalid_argument("'" + pattern + "' selects no output: " + fault);
    const std::int64_t every =
        at == std::string::npos ? 1 : parse_every(item, std::string_view(item).substr(at + 1), dt);
    const auto same = [every](const OutputGroup& group) { return group.rate.every == every; };
    auto group = std::ranges::find_if(groups, same);
    if (group == groups.end()) group = groups.insert(groups.end(), OutputGroup{{}, {every, 0}});
    group->patterns.push_back(pattern);
  }
  return groups;
}

std::int64_t calc_every(double rate, double dt) {
  const double ticks = 1 / (rate * dt);
  const bool whole = ticks >= 1 - kSameTime && ticks <= kMaxEvery && std::abs(ticks - std::round(ticks)) <= kSameTime;
  return whole ? std::llround(ticks) : 0;
}

}  // namespace unlatch::hil
