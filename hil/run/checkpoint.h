// Checkpoints: a run up to T is the same bits as one up to t, written down, and taken up from t to T. A checkpoint is a
// file of one sealed event (hil/recording/log_format.h): everything that a recording beginning at that tick would begin
// with.
#pragma once

#include <string>

#include "hil/recording/log_format.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

// The present state of a run without flight software. The file is there complete, or as it was before: it is written
// under another name, handed to the disk and renamed. Throws LogWriteError.
void write_checkpoint(const std::string& path, const Scenario& scenario, const Simulation& simulation,
                      std::int64_t last_tick);

// Takes a run of `scenario` to the checkpoint's state. Throws LogError, and leaves the simulation as it was: no
// checkpoint, a damaged one, or one of another version, scenario, step or model.
void read_checkpoint(const std::string& path, const Scenario& scenario, Simulation& simulation);

}  // namespace unlatch::hil
