#include "hil/replay.h"

#include "hil/run.h"

namespace unlatch::hil {
namespace {

class Replayer {
 public:
  Replayer(Simulation& simulation, RunAnalysis* analysis, ReplayResult& result)
      : simulation_(simulation), analysis_(analysis), result_(result) {
    if (analysis_ != nullptr) analysis_->update(StepReport{});
  }

  bool compare(std::int64_t recorded) {
    const std::int64_t replayed = simulation_.calc_hash();
    if (simulation_.get_tick() > last_compared_) ++result_.compared;  // a step that failed ends where it began
    last_compared_ = simulation_.get_tick();
    if (replayed == recorded) return true;
    result_.difference = {simulation_.get_tick(), recorded, replayed};
    return false;
  }

  bool step(const LogTick& tick) {
    for (const LogChange& change : tick.changes) {
      if (change.channel < 0 || static_cast<std::size_t>(change.channel) >= simulation_.channels().size()) {
        result_.mismatch = "tick " + std::to_string(tick.tick) + " sets a channel that the scenario does not have";
        return false;
      }
      simulation_.channels()[static_cast<std::size_t>(change.channel)] = change.value;
    }
    const StepReport report = simulation_.step();
    status_ = report.status;
    if (status_ == StepStatus::kOk && analysis_ != nullptr) analysis_->update(report);
    return status_ == StepStatus::kOk;
  }

  void check_end(const LogEnd& end) {
    if (end.step_status != static_cast<std::int32_t>(status_)) {
      result_.mismatch = std::string("the last step ends with '") + get_status_text(status_) + "', recorded was '" +
                         get_status_text(static_cast<StepStatus>(end.step_status)) + "'";
    } else if (end.tick != simulation_.get_tick()) {
      result_.mismatch = "the replay ends at tick " + std::to_string(simulation_.get_tick()) +
                         ", the recording at tick " + std::to_string(end.tick);
    } else {
      compare(end.hash);
    }
  }

  [[nodiscard]] bool has_faulted() const { return status_ != StepStatus::kOk; }
  [[nodiscard]] StepStatus get_status() const { return status_; }

 private:
  Simulation& simulation_;
  RunAnalysis* analysis_;
  ReplayResult& result_;
  StepStatus status_ = StepStatus::kOk;
  std::int64_t last_compared_ = -1;
};

void refuse_if_lossy(std::int64_t unrecorded) {
  if (unrecorded == 0) return;
  throw LogError("the recording is not replayable: " + std::to_string(unrecorded) +
                 " of its items were lost on their way to the disk");
}

}  // namespace

Scenario load_recorded_scenario(const LogHeader& header) {
  return load_scenario_text(header.scenario_text, header.scenario_path, header.overrides);
}

std::unique_ptr<Simulation> build_recorded_simulation(const LogHeader& header, const Scenario& scenario,
                                                      const std::string& name) {
  auto simulation = build_simulation(scenario);
  if (static_cast<std::int64_t>(simulation->plan().hash) == header.model_hash) return simulation;
  throw LogError(name + ": scenario '" + header.scenario_name +
                 "' compiles to another model here than in the program that recorded it (" + header.program + ", " +
                 header.compiler + "); replay it with that one");
}

// A tick's inputs are stepped with once the next record shows that its step was made.
ReplayResult replay(RecordingReader& recording, Simulation& simulation, RunAnalysis* analysis) {
  ReplayResult result;
  Replayer replayer(simulation, analysis, result);
  LogTick pending, tick;
  bool has_pending = false;
  while (recording.next(tick)) {
    refuse_if_lossy(tick.unrecorded);
    if (has_pending && !replayer.step(pending)) {
      if (replayer.has_faulted())
        result.mismatch = "the step of tick " + std::to_string(pending.tick) +
                          " fails here: " + get_status_text(replayer.get_status());
      return result;
    }
    if (!replayer.compare(tick.hash)) return result;
    std::swap(pending, tick);
    has_pending = true;
  }
  if (recording.end) {
    refuse_if_lossy(recording.end->unrecorded);
    if (has_pending && !replayer.step(pending) && !replayer.has_faulted()) return result;
    replayer.check_end(*recording.end);
  }
  return result;
}

}  // namespace unlatch::hil
