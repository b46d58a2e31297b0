// The channels of a simulation during a session: commands, policies and faults set them here, and each change is
// recorded. A channel with a fault takes a command when the fault has ended. Fixed memory.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hil/run/recording/recorder.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"
#include "hil/session/faults/channel_faults.h"
#include "hil/session/faults/fault_injector.h"

namespace unlatch::hil {

class ChannelWriter {
 public:
  // `faults`: null for none. All must outlive it.
  ChannelWriter(Simulation& simulation, Recorder& recorder, FaultInjector* faults);

  // One value from the present tick on; of a command its sender is from now on the channel's commander.
  void set(const LogChange& change) noexcept;
  // The values of `policy`, for channels whose commander is `lost`, a participant's index, and for those without one.
  void apply_policy(Policy policy, std::int32_t lost) noexcept;
  // The value of each channel at the beginning of a tick: its fault's, or the latest commanded.
  void update_faults() noexcept;

 private:
  Simulation& simulation_;
  Recorder& recorder_;
  std::optional<ChannelFaults> faults_;
  std::vector<std::optional<std::int32_t>> commanders_;  // sender of each channel's latest command, an index
};

}  // namespace unlatch::hil
