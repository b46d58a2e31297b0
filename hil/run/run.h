// Runs without flight software, and the parts that all runs share.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/recording/recorder.h"
#include "hil/run/run_record.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

// Compiles the scenario for its own step. Throws ScenarioError with the places of the faulty elements.
// `set`: for tests.
std::unique_ptr<Simulation> build_simulation(const Scenario& scenario, InstructionSet set = InstructionSet::kAuto);

// Returns a random session number, > 0.
std::int64_t draw_session();

// Header of a recording of this run that begins at the simulation's present tick.
LogHeader build_log_header(const Scenario& scenario, const Simulation& simulation, Pace pace, std::int64_t session,
                           std::int64_t last_tick);

// A run without flight software, tick by tick: for a caller that steps several side by side.
class FastRun {
 public:
  using Look = std::function<void(const StepReport&)>;
  // `analysis` and `recorder` may be null. `look` is called at every tick with the report of the step; at the first
  // tick, in the constructor, with a default report. Keeps references to all arguments.
  FastRun(Simulation& simulation, RunAnalysis* analysis, Recorder* recorder, std::int64_t last_tick, Look look);

  [[nodiscard]] bool goes_on() const { return end_.status == RunStatus::kDone && simulation_.get_tick() < last_tick_; }
  // Called before and after each step.
  void begin_tick() { record_.tick(); }
  void end_tick(const StepReport& report);
  void interrupt();
  // End of the run, without times of steps.
  [[nodiscard]] LogEnd finish();

 private:
  [[nodiscard]] RunStatus get_status() const;

  Simulation& simulation_;
  RunAnalysis* analysis_;
  RunRecord record_;
  const std::int64_t last_tick_;
  const Look look_;
  LogEnd end_;
  StepReport fault_;  // of the step that failed
};

// Steps as fast as possible to `last_tick`, with analysis, and with recording if `recorder` is not null. Another thread
// may set `stop`, which ends the run as aborted. `look` is called at every tick, the first and the last included.
LogEnd run_fast(Simulation& simulation, RunAnalysis& analysis, Recorder* recorder, std::int64_t last_tick,
                const std::atomic<bool>& stop, const std::function<void()>& look);

// Description of a step that failed at a tick: "singular pivot at joint 'nose1', tick 412 (t = 0.412 s)".
std::string describe_fault(const StepReport& report, std::int64_t tick, const Model& model, double dt);

}  // namespace unlatch::hil
