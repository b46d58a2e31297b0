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
};

// Hash of the plan and of the rates of channels and sensors: two models with one hash have the same states from the
// same inputs. Without groups it is the plan's hash. The rate of States has no influence on states and is left out.
std::uint64_t calc_hash(const Rates& rates, std::uint64_t plan_hash) noexcept;

// Rates compiled for a model: the held values, and the ticks of their updates. Only the constructor allocates.
class SampleAndHold {
 public:
  SampleAndHold(const Model& model, const Rates& rates, std::span<const double> channels,
                std::span<const double> sensors);

  // Latches channels before the step of `tick`; those without a group are latched at every tick.
  void latch(std::int64_t tick, std::span<const double> commanded) noexcept;
  // Samples sensors of the state of `tick`.
  void sample(std::int64_t tick, std::span<const double> measured) noexcept;

  // Restores held values that get_channels() and get_sensors() returned earlier.
  void restore(std::span<const double> channels, std::span<const double> sensors) noexcept;

  [[nodiscard]] std::span<const double> get_channels() const noexcept { return channels_; }
  [[nodiscard]] std::span<const double> get_sensors() const noexcept { return sensors_; }
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
  const Rate states_;
};

}  // namespace unlatch::hil
