// Channels with a fault, dead or jammed: commands for them are kept until it ends.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "hil/session/faults/fault_injector.h"

namespace unlatch::hil {

class ChannelFaults {
 public:
  // `channels`: values at the beginning. `faults` must outlive it.
  ChannelFaults(FaultInjector& faults, std::span<const double> channels)
      : faults_(faults), commanded_(channels.begin(), channels.end()) {}

  // Keeps the commanded `value`. True if the channel, at `now`, takes it: it has no fault.
  [[nodiscard]] bool command(std::size_t channel, double value, double now) noexcept {
    commanded_[channel] = value;
    return !faults_.get_forced(channel, now);
  }
  // Value that the channel, at `now`, has from this tick on: the fault's, or the latest commanded.
  [[nodiscard]] double calc_value(std::size_t channel, double now) noexcept {
    return faults_.get_forced(channel, now).value_or(commanded_[channel]);
  }

 private:
  FaultInjector& faults_;
  std::vector<double> commanded_;
};

}  // namespace unlatch::hil
