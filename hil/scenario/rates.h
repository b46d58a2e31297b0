// Rates: channels, sensors and States that are updated at some ticks only. A group of channels is latched, a group of
// sensors sampled, and the States are sent at the ticks k with k mod every = phase; in between, channels and sensors
// hold their values. Each channel and sensor is in one group at most, so the order of groups, that of the file, has no
// effect.
//
//   before the step of tick k   channels whose group is due take their commanded values
//   after the step to tick k    sensors whose group is due take new values; then the State goes out, if it is due
//
// The tick alone decides all of it, so a replay does the same.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hil/scenario/sensor_errors.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct Rate {
  std::int64_t every = 1, phase = 0;  // ticks; 0 <= phase < every
  [[nodiscard]] bool is_due(std::int64_t tick) const noexcept { return tick % every == phase; }
};

struct RateGroup {
  std::string name;
  Rate rate;
  std::vector<int> channels, sensors;  // indices of the model
};

struct Rates {
  std::vector<RateGroup> groups;  // in the order of the file
  Rate states;
  SensorErrorModel errors;  // what sensors deliver instead of the true values
};

// Hash of the plan, of the rates of channels and sensors, and of the sensors' errors: two models with one hash have the
// same states from the same inputs. Without groups and errors it is the plan's hash. The rate of States has no
// influence on states and is left out.
std::uint64_t calc_hash(const Rates& rates, std::uint64_t plan_hash) noexcept;

// Rates compiled for a model: the held values, and the ticks of their updates. Only the constructor allocates.
class SampleAndHold {
 public:
  SampleAndHold(const Model& model, const Rates& rates, std::span<const double> channels,
                std::span<const double> sensors);

  // Latches channels before the step of `tick`; those without a group are latched at every tick.
  void latch(std::int64_t tick, std::span<const double> commanded) noexcept;
  // Samples sensors of the state of `tick`, with their errors.
  void sample(std::int64_t tick, std::span<const double> measured) noexcept;

  // Restores held values that get_channels(), get_sensors() and get_memory() returned earlier.
  void restore(std::span<const double> channels, std::span<const double> sensors,
               std::span<const double> memory) noexcept;

  [[nodiscard]] std::span<const double> get_channels() const noexcept { return channels_; }
  [[nodiscard]] std::span<const double> get_sensors() const noexcept { return sensors_; }
  // What further errors of sensors depend on; empty without errors.
  [[nodiscard]] std::span<const double> get_memory() const noexcept { return measurement_.memory(); }
  [[nodiscard]] bool is_state_due(std::int64_t tick) const noexcept { return states_.is_due(tick); }

 private:
  struct Part {
    Rate rate;
    std::vector<std::int32_t> places;
  };
  static void renew(const std::vector<Part>& parts, std::int64_t tick, std::span<const double> from,
                    std::span<double> to) noexcept;
  std::vector<Part> channel_parts_, sensor_parts_;
  std::vector<double> channels_, sensors_;
  std::vector<std::int64_t> every_, phases_;  // of each sensor, ticks
  Measurement measurement_;
  std::vector<double> measured_;  // scratch, with errors alone
  const Rate states_;
};

}  // namespace unlatch::hil
