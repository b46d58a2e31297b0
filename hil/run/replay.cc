#include "hil/run/replay.h"

#include <utility>

#include "hil/run/run.h"

namespace unlatch::hil {
namespace {

class Replayer {
 public:
  using Look = std::function<void(const StepReport&)>;
  Replayer(const RecordingReader& recording, Simulation& simulation, RunAnalysis* analysis, const Look& look,
           ReplayResult& result)
      : recording_(recording), simulation_(simulation), analysis_(analysis), look_(look), result_(result) {}

  // Shows the first state; once its record, or the end, is read.
  void begin() {
    if (!std::exchange(begun_, true)) show(StepReport{});
  }

  bool compare(std::int64_t recorded) {
    const std::int64_t replayed = simulation_.calc_hash();
    if (simulation_.get_tick() > last_compared_) ++result_.compared;  // a failed step ends at its first tick
    last_compared_ = simulation_.get_tick();
    if (replayed == recorded) return true;
    result_.difference = {simulation_.get_tick(), recorded, replayed};
    return false;
  }

  bool step(const LogTick& tick) {
    for (const LogChange& change : tick.changes) apply(change, simulation_);
    const StepReport report = simulation_.step();
    status_ = report.status;
    if (status_ == StepStatus::kOk) show(report);
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

  [[nodiscard]] StepStatus get_status() const { return status_; }

 private:
  void show(const StepReport& report) {
    if (analysis_ != nullptr) analysis_->update(report, recording_.received);
    if (look_) look_(report);
  }

  const RecordingReader& recording_;
  Simulation& simulation_;
  RunAnalysis* analysis_;
  const Look& look_;
  ReplayResult& result_;
  StepStatus status_ = StepStatus::kOk;
  std::int64_t last_compared_ = -1;
  bool begun_ = false;
};

}  // namespace

Scenario load_recorded_scenario(const LogHeader& header) {
  return load_scenario_text(header.scenario_text, header.scenario_path, header.overrides);
}

std::unique_ptr<Simulation> build_recorded_simulation(const LogHeader& header, const Scenario& scenario,
                                                      const std::string& name) {
  auto simulation = build_simulation(scenario);
  if (simulation->get_model_hash() == header.model_hash) {
    if (header.start.empty() || simulation->restore(header.start, header.begins_unresolved)) return simulation;
    throw LogError(name +
                   ": begins at a state that this program's model cannot have; replay it with the program that " +
                   "recorded it");
  }
  throw LogError(name + ": scenario '" + header.scenario_name +
                 "' compiles to another model here than in the program that recorded it (" + header.program + ", " +
                 header.compiler + "); use that one");
}

void refuse_if_lossy(const RecordingReader& recording, std::int64_t items) {
  if (items == 0) return;
  throw LogError(recording.get_name() + ": is not replayable: " + std::to_string(items) +
                 " of its items were lost on their way to the disk");
}

void apply(const LogChange& change, Simulation& simulation) {
  if (change.channel < 0 || static_cast<std::size_t>(change.channel) >= simulation.channels().size()) {
    throw LogError("the recording sets channel " + std::to_string(change.channel) +
                   ", which its scenario does not have; it was not written by unlatch");
  }
  simulation.channels()[static_cast<std::size_t>(change.channel)] = change.value;
}

// Replays a recording. The inputs of a tick are applied once the next record confirms that its step was made.
ReplayResult replay(RecordingReader& recording, Simulation& simulation, RunAnalysis* analysis,
                    const std::function<void(const StepReport&)>& look) {
  ReplayResult result;
  Replayer replayer(recording, simulation, analysis, look, result);
  LogTick pending, tick;
  bool has_pending = false;
  while (recording.next(tick)) {
    refuse_if_lossy(recording, tick.unrecorded);
    replayer.begin();
    if (has_pending && !replayer.step(pending)) {
      result.mismatch =
          "the step of tick " + std::to_string(pending.tick) + " fails here: " + get_status_text(replayer.get_status());
      return result;
    }
    if (!replayer.compare(tick.hash)) return result;
    std::swap(pending, tick);
    has_pending = true;
  }
  replayer.begin();
  if (recording.end) {
    refuse_if_lossy(recording, recording.end->unrecorded);
    if (has_pending) replayer.step(pending);
    replayer.check_end(*recording.end);
  }
  return result;
}

}  // namespace unlatch::hil
