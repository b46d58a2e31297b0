// Runs without flight software, and what all runs have in common.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hil/analysis/run_analysis.h"
#include "hil/recording/recorder.h"
#include "hil/run/run_record.h"
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

// A run without flight software, from tick to tick: for a caller that steps several side by side.
class FastRun {
 public:
  using Look = std::function<void(const StepReport&)>;
  // Analyses as it goes and records where these are not null. `look` is called at every tick with what the step
  // reported, at the first, here, with a default report. All are referred to.
  FastRun(Simulation& simulation, RunAnalysis* analysis, Recorder* recorder, std::int64_t last_tick, Look look);

  [[nodiscard]] bool goes_on() const { return end_.status == RunStatus::kDone && simulation_.get_tick() < last_tick_; }
  // Before and after each step.
  void begin_tick() { record_.tick(); }
  void end_tick(const StepReport& report);
  void interrupt();
  // How it ended, without times of steps.
  [[nodiscard]] LogEnd finish();

 private:
  [[nodiscard]] RunStatus get_status() const;

  Simulation& simulation_;
  RunAnalysis* analysis_;
  RunRecord record_;
  const std::int64_t last_tick_;
  const Look look_;
  LogEnd end_;
};

// Steps as fast as it can to `last_tick`, analysing as it goes and recording if `recorder` is not null. Another thread
// may set `stop`, which ends it as aborted. `look` is called at every tick, the first and the last included.
LogEnd run_fast(Simulation& simulation, RunAnalysis& analysis, Recorder* recorder, std::int64_t last_tick,
                const std::atomic<bool>& stop, const std::function<void()>& look);

// "singular pivot at joint 'nose1', tick 412 (t = 0.412 s)", of a step that failed.
std::string describe_fault(const LogEnd& end, const Model& model, double dt);

}  // namespace unlatch::hil
