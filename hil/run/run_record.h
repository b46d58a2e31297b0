// Recording of a run without flight software: States at intervals, events, changes of channels, and the hash of every
// tick. Without a recorder it does nothing. Only the constructor allocates.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/run/recording/recorder.h"
#include "hil/run/simulation/simulation.h"

namespace unlatch::hil {

class RunRecord {
 public:
  // `recorder` may be null; keeps references to both.
  RunRecord(const Simulation& simulation, Recorder* recorder);

  // Records the present state, if it is due or its status is not kRunning.
  void state(RunStatus status) noexcept;
  // Records a channel's value from this tick on; called before a step.
  void change(std::size_t channel, double value) noexcept;
  // Records a tick; called before a step, after its changes.
  void tick() noexcept;
  // Records the events of a completed step.
  void events(const StepReport& report) noexcept;

 private:
  const Simulation& simulation_;
  Recorder* recorder_;
  const std::int64_t dt_ns_;
  const std::vector<EventMessage> events_;
  std::int64_t sequence_ = 0, event_sequence_ = 0, change_sequence_ = 0;
};

}  // namespace unlatch::hil
