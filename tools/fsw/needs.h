// Channels and sensors that a control law needs, looked up by name; missing ones are gathered in words.
#pragma once

#include <string>

#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

class Needs {
 public:
  explicit Needs(const Vehicle& vehicle) : vehicle_(vehicle) {}

  // The index; -1 if it is missing.
  int channel(const std::string& name) { return note(vehicle_.find_channel(name), "channel " + name); }
  int sensor(const std::string& name) { return note(vehicle_.find_sensor(name), "sensor " + name); }
  // The channel's value before any command; 0 if it is missing.
  double initial_value(const std::string& name) {
    const int index = channel(name);
    return index < 0 ? 0 : vehicle_.get_limits(index).initial;
  }

  // "channel nozzle1, sensor kr1"
  [[nodiscard]] const std::string& get_missing() const { return missing_; }

 private:
  int note(int index, const std::string& item) {
    if (index < 0) missing_ += (missing_.empty() ? "" : ", ") + item;
    return index;
  }

  const Vehicle& vehicle_;
  std::string missing_;
};

}  // namespace unlatch::fsw
