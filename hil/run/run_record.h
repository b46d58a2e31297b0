// The recording of a run without flight software, as it goes: a State now and then, events, changes of channels, and
// the hash of every tick. Without a recorder it does nothing. Only the constructor allocates.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/recording/recorder.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

class RunRecord {
 public:
  // `recorder` may be null; both must outlive this.
  RunRecord(const Simulation& simulation, Recorder* recorder);

  // The present state, if it is time for one, or with another status than kRunning.
  void state(RunStatus status) noexcept;
  // Before a step: a channel's value from this tick on.
  void change(std::size_t channel, double value) noexcept;
  // Before a step, after its changes.
  void tick() noexcept;
  // Events of the step that was made.
  void events(const StepReport& report) noexcept;

 private:
  const Simulation& simulation_;
  Recorder* recorder_;
  const std::int64_t dt_ns_;
  const std::vector<EventMessage> events_;
  std::int64_t sequence_ = 0, event_sequence_ = 0, change_sequence_ = 0;
};

}  // namespace unlatch::hil
