// The flight software's view of the simulator: names and sensor values from its messages.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "hil/session/messages/messages.h"

namespace unlatch::fsw {

class Vehicle {
 public:
  // A new session: everything is unknown again.
  void begin(const hil::HelloMessage& hello);
  void learn(const hil::CatalogMessage& item);
  // Every channel, body and sensor value that the Hello announced has been named.
  [[nodiscard]] bool is_known() const;

  // Takes one part of a tick's State; true once all parts of that tick are there (part 0 comes last).
  bool sense(const hil::StateMessage& part);

  [[nodiscard]] int find_channel(const std::string& name) const { return find(channels_, name); }
  [[nodiscard]] int find_sensor(const std::string& name) const { return find(sensor_names_, name); }
  [[nodiscard]] int find_body(const std::string& name) const { return find(body_names_, name); }
  // Limits of a channel, in its unit.
  struct Limits {
    double minimum = 0, maximum = 0;
    double initial = 0;  // before any command
  };
  [[nodiscard]] const Limits& get_limits(int channel) const { return limits_[static_cast<std::size_t>(channel)]; }
  [[nodiscard]] double get_sensor(int index) const { return sensors_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const hil::BodyStateMessage& get_body(int index) const {
    return bodies_[static_cast<std::size_t>(index)];
  }

 private:
  using Names = std::map<std::string, int>;
  static int find(const Names& names, const std::string& name);

  Names channels_, sensor_names_, body_names_;
  std::vector<Limits> limits_;  // of channels
  std::vector<double> sensors_;
  std::vector<hil::BodyStateMessage> bodies_;
  std::int64_t sensed_tick_ = -1;
  std::int32_t parts_sensed_ = 0;
};

// The flight software's commands for one tick.
class Commands {
 public:
  struct Setting {
    int channel;
    double value;
  };
  void set(int channel, double value) { settings_.push_back({channel, value}); }
  void clear() { settings_.clear(); }
  [[nodiscard]] const std::vector<Setting>& get() const { return settings_; }

 private:
  std::vector<Setting> settings_;
};

}  // namespace unlatch::fsw
