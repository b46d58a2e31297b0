// Runs without flight software, and what all runs have in common.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hil/analysis/run_analysis.h"
#include "hil/recording/recorder.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"

namespace unlatch::hil {

// The scenario compiled for its own step. Throws ScenarioError with the places of the offending elements.
std::unique_ptr<Simulation> build_simulation(const Scenario& scenario);

// A random session number, > 0.
std::int64_t draw_session();

// The header of a recording of this run that begins at the simulation's present tick.
LogHeader build_log_header(const Scenario& scenario, const Simulation& simulation, Pace pace, std::int64_t session,
                           std::int64_t last_tick);

// Steps as fast as it can to `last_tick`, analysing as it goes and recording if `recorder` is not null. Another thread
// may set `stop`, which ends it as aborted. `look` is called at every tick, the first and the last included.
LogEnd run_fast(Simulation& simulation, RunAnalysis& analysis, Recorder* recorder, std::int64_t last_tick,
                const std::atomic<bool>& stop, const std::function<void()>& look);
// The same, analysing if `analysis` is not null; `look` gets what the step reported, and at the first tick a default
// report.
LogEnd run_fast(Simulation& simulation, RunAnalysis* analysis, Recorder* recorder, std::int64_t last_tick,
                const std::atomic<bool>& stop, const std::function<void(const StepReport&)>& look);

// "singular pivot at joint 'nose1', tick 412 (t = 0.412 s)", of a step that failed.
std::string describe_fault(const LogEnd& end, const Model& model, double dt);

}  // namespace unlatch::hil
