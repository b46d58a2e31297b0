// Rates: channels, sensors and States that are not renewed at every tick. A group of channels is latched, a group of
// sensors sampled, and the States are sent at the ticks k with k mod every = phase; in between channels and sensors
// hold. Each channel and sensor is in one group at most, so the order of groups, that of the file, decides nothing.
//
//   before the step of tick k   channels whose group is due take their commanded values
//   after the step to tick k    sensors whose group is due take new values; then the State goes out, if it is due
//
// All of it is decided by the tick alone, so a replay does the same.
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

// A plan's hash, and of what is held when: two models with one hash have the same states from the same inputs. Without
// groups it is the plan's. When States are sent decides no state.
std::uint64_t calc_hash(const Rates& rates, std::uint64_t plan_hash) noexcept;

// Rates compiled for a model: what is held, and when it is renewed. Only the constructor allocates.
class SampleAndHold {
 public:
  SampleAndHold(const Model& model, const Rates& rates, std::span<const double> channels,
                std::span<const double> sensors);

  // Before the step of `tick`; what is not in a group is taken always.
  void latch(std::int64_t tick, std::span<const double> commanded) noexcept;
  // The state is that of `tick` now.
  void sample(std::int64_t tick, std::span<const double> measured) noexcept;

  // The values held, as get_channels() and get_sensors() gave them at another time.
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
