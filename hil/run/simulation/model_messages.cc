#include "hil/run/simulation/model_messages.h"

#include <algorithm>
#include <span>
#include <string>

#include "hil/scenario/outputs.h"
#include "hil/scenario/quantities.h"

namespace unlatch::hil {
namespace {

// Number of `total` items in part `part`, of `capacity` items each.
std::int32_t calc_share(std::size_t total, std::int32_t part, std::size_t capacity) {
  const std::size_t first = static_cast<std::size_t>(part) * capacity;
  return total <= first ? 0 : static_cast<std::int32_t>(std::min(total - first, capacity));
}

std::size_t calc_parts(std::size_t total, std::size_t capacity) { return (total + capacity - 1) / capacity; }

BodyStateMessage to_message(const BodyState& body) {
  return {body.p.x, body.p.y, body.p.z, body.q.w, body.q.x, body.q.y, body.q.z,
          body.v.x, body.v.y, body.v.z, body.w.x, body.w.y, body.w.z};
}

CatalogMessage make_item(CatalogKind kind, std::size_t index, const std::string& name, const char* unit) {
  CatalogMessage item;
  item.kind = static_cast<std::int32_t>(kind);
  item.index = static_cast<std::int32_t>(index);
  set_name(item.name, name);
  set_name(item.unit, unit);
  return item;
}

}  // namespace

std::int32_t count_state_parts(const Simulation& simulation) noexcept {
  const State& state = simulation.state();
  const std::size_t parts = std::max({calc_parts(state.bodies.size(), kBodiesPerPart),
                                      calc_parts(simulation.get_sensors().size(), kSensorsPerPart),
                                      calc_parts(state.joints.size(), kJointsPerPart), std::size_t{1}});
  return static_cast<std::int32_t>(parts);
}

void fill_state(const Simulation& simulation, std::int32_t part, std::int64_t dt_ns, StateMessage& message) noexcept {
  const State& state = simulation.state();
  const std::span<const double> sensors = simulation.get_sensors();
  message.tick = simulation.get_tick();
  message.time_ns = simulation.get_tick() * dt_ns;
  message.part = part;
  message.parts = count_state_parts(simulation);
  message.body_count = calc_share(state.bodies.size(), part, kBodiesPerPart);
  message.sensor_count = calc_share(sensors.size(), part, kSensorsPerPart);
  message.joint_count = calc_share(state.joints.size(), part, kJointsPerPart);
  const auto first = static_cast<std::size_t>(part);
  for (std::size_t i = 0; i < static_cast<std::size_t>(message.body_count); ++i) {
    message.bodies[i] = to_message(state.bodies[first * kBodiesPerPart + i]);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(message.sensor_count); ++i) {
    message.sensors[i] = sensors[first * kSensorsPerPart + i];
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(message.joint_count); ++i) {
    message.modes[i] = static_cast<std::uint8_t>(state.joints[first * kJointsPerPart + i].mode);
  }
}

std::vector<CatalogMessage> build_catalog(const Model& model) {
  std::vector<CatalogMessage> items;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    items.push_back(make_item(CatalogKind::kBody, i, model.bodies[i].name, ""));
  }
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    items.push_back(make_item(CatalogKind::kJoint, i, model.joints[i].name, ""));
  }
  for (std::size_t i = 0; i < model.channels.size(); ++i) {
    const Channel& channel = model.channels[i];
    CatalogMessage item = make_item(CatalogKind::kChannel, i, channel.name, channel.unit.c_str());
    item.minimum = channel.minimum;
    item.maximum = channel.maximum;
    item.initial = channel.initial;
    item.safe = channel.safe;
    items.push_back(item);
  }
  std::size_t value = 0;
  for (const Sensor& sensor : model.sensors) {
    const std::string unit = get_unit(model, sensor);
    for (const char* component : get_sensor_components(sensor.kind)) {
      items.push_back(make_item(CatalogKind::kSensor, value++, sensor.name + component, unit.c_str()));
    }
  }
  for (std::size_t i = 0; i < model.signals.size(); ++i) {
    items.push_back(make_item(CatalogKind::kSignal, i, model.signals[i], "1"));
  }
  return items;
}

std::vector<EventMessage> build_event_messages(const Model& model) {
  std::vector<EventMessage> messages;
  for (const Event& event : model.events) {
    EventMessage& message = messages.emplace_back();
    set_name(message.name, event.name);
    set_name(message.subject, event.subject);
  }
  return messages;
}

}  // namespace unlatch::hil
