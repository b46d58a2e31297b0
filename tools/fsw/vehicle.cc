#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

void Vehicle::begin(const hil::HelloMessage& hello) {
  *this = Vehicle{};
  limits_.assign(static_cast<std::size_t>(hello.channel_count), {});
  sensors_.assign(static_cast<std::size_t>(hello.sensor_count), 0);
  bodies_.assign(static_cast<std::size_t>(hello.body_count), {});
}

void Vehicle::learn(const hil::CatalogMessage& item) {
  const std::string name(hil::get_name(item.name));
  if (item.kind == static_cast<int>(hil::CatalogKind::kChannel) &&
      static_cast<std::size_t>(item.index) < limits_.size()) {
    channels_[name] = item.index;
    limits_[static_cast<std::size_t>(item.index)] = {item.minimum, item.maximum, item.initial};
  }
  if (item.kind == static_cast<int>(hil::CatalogKind::kSensor) &&
      static_cast<std::size_t>(item.index) < sensors_.size()) {
    sensor_names_[name] = item.index;
  }
  if (item.kind == static_cast<int>(hil::CatalogKind::kBody) && static_cast<std::size_t>(item.index) < bodies_.size()) {
    body_names_[name] = item.index;
  }
}

bool Vehicle::is_known() const {
  return channels_.size() == limits_.size() && sensor_names_.size() == sensors_.size() &&
         body_names_.size() == bodies_.size();
}

bool Vehicle::sense(const hil::StateMessage& part) {
  if (part.tick != sensed_tick_) parts_sensed_ = 0;
  sensed_tick_ = part.tick;
  const std::size_t first = static_cast<std::size_t>(part.part) * hil::kSensorsPerPart;
  for (std::size_t i = 0; i < static_cast<std::size_t>(part.sensor_count); ++i) {
    if (first + i < sensors_.size()) sensors_[first + i] = part.sensors[i];
  }
  const std::size_t first_body = static_cast<std::size_t>(part.part) * hil::kBodiesPerPart;
  for (std::size_t i = 0; i < static_cast<std::size_t>(part.body_count); ++i) {
    if (first_body + i < bodies_.size()) bodies_[first_body + i] = part.bodies[i];
  }
  ++parts_sensed_;
  return part.part == 0 && parts_sensed_ >= part.parts;
}

int Vehicle::find(const Names& names, const std::string& name) {
  const auto found = names.find(name);
  return found == names.end() ? -1 : found->second;
}

}  // namespace unlatch::fsw
