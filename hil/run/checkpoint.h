// Checkpoints: a run up to T has the same bits as one up to t, stored, and continued from t to T. A checkpoint is a
// file of one sealed event (hil/run/recording/log_format.h): the data with which a recording from that tick would
// begin.
#pragma once

#include <string>

#include "hil/run/recording/log_format.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

// Writes the present state of a run without flight software. The file is complete, or unchanged: it is written under
// another name, flushed to the disk and renamed. `unresolved`: the step has not resolved something of the run so far,
// which a run that goes on from here is told (Simulation::begins_unresolved()). Throws LogWriteError.
void write_checkpoint(const std::string& path, const Scenario& scenario, const Simulation& simulation,
                      std::int64_t last_tick, bool unresolved = false);

// Sets a run of `scenario` to the checkpoint's state. Throws LogError and leaves the simulation unchanged if the file
// is no checkpoint, damaged, or of another version, scenario, step or model.
void read_checkpoint(const std::string& path, const Scenario& scenario, Simulation& simulation);

}  // namespace unlatch::hil
