// Replays a recording and compares the state's hash at every tick.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "hil/run/analysis/run_analysis.h"
#include "hil/run/recording/replay_reader.h"

namespace unlatch::hil {

struct ReplayDifference {
  std::int64_t tick = 0;
  std::int64_t recorded = 0, replayed = 0;  // hashes
};

struct ReplayResult {
  std::int64_t compared = 0;                   // ticks whose hashes were compared
  std::optional<ReplayDifference> difference;  // the first difference
  std::string mismatch;  // difference other than a hash: the run ends in another way than recorded
  [[nodiscard]] bool agrees() const { return !difference && mismatch.empty(); }
};

// Loads the scenario of a recording, from the text in it. Throws ScenarioError.
Scenario load_recorded_scenario(const LogHeader& header);
// Builds its simulation, at the state where the recording begins. Throws LogError if this program compiles the scenario
// to another model; `name`: of the recording, for the message.
std::unique_ptr<Simulation> build_recorded_simulation(const LogHeader& header, const Scenario& scenario,
                                                      const std::string& name);

// Throws LogError if a recording has lost `items` of its inputs: its replay would be another run.
void refuse_if_lossy(const RecordingReader& recording, std::int64_t items);
// Sets the channel of a recorded change. Throws LogError if the scenario has no such channel.
void apply(const LogChange& change, Simulation& simulation);

// Steps `simulation`, which must be at the state where the recording begins, through the recording; stops at the first
// difference. `analysis` may be null. `look`, if given, is called at every state, the first included, after the
// analysis and with the same report. Throws LogError for a recording that lost inputs: it cannot be replayed.
ReplayResult replay(RecordingReader& recording, Simulation& simulation, RunAnalysis* analysis,
                    const std::function<void(const StepReport&)>& look = {});

}  // namespace unlatch::hil
