// Evaluation of one sample of a scenario, in this process: settings in, results out. Campaigns, optimisation and
// batches use it.
//
//   const ScenarioTree tree("boosters/reference.yaml");      // parsed once
//   const SampleEvaluator evaluator(tree);                    // threads may share both
//   const Setting settings[] = {make_setting("bodies.core.mass", 98000.0)};
//   const SampleResult result = evaluator.evaluate(settings);
//   result.values[*evaluator.find("distance1")]
//
// A result depends on the scenario and the settings alone, and has the bits of `unlatch run --set`: nothing is kept
// from one sample to the next.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/scenario/scenario_tree.h"
#include "hil/scenario/yaml/setting.h"
#include "hil/session/messages/messages.h"
#include "hil/study/evaluation/chosen_outputs.h"
#include "hil/study/evaluation/results.h"
#include "unlatch/bundle.h"

namespace unlatch::hil {

enum class SampleStatus {
  kDone,         // ran to its end
  kFaulted,      // the step failed: `message` names the joint and the tick; values up to that tick
  kInvalid,      // the settings make no valid scenario: `message` lists all mistakes; no values
  kUnresolved,   // ran to its end, but the step did not resolve something, which `message` names: values are no results
  kInterrupted,  // ended by `stop`: no result
};
extern const std::vector<std::string> kSampleStatusNames;  // "done" …, in the order of the enum

struct SampleResult {
  SampleStatus status = SampleStatus::kDone;
  std::string message;          // why there is no result
  std::int64_t ticks = 0;       // tick of the last good state
  std::int64_t hash = 0;        // hash of that state, as `run` prints it
  std::int64_t model_hash = 0;  // hash of model, plan and rates, equal to that of a file loaded with the same values
  std::vector<double> values;   // one for each column
};

// Options of a sample's run that differ from the scenario.
struct SampleRun {
  double until = 0;    // s; 0: the scenario's end
  bool judges = true;  // false: no values; the run has the speed of the step alone
  // For tests: results do not depend on it.
  InstructionSet instruction_set = InstructionSet::kAuto;
  // Called at every tick, the first included, with the report of its step; and at the end, with the last good state. A
  // ScenarioError from it makes the sample invalid. May be empty.
  std::function<void(const Scenario&, const Simulation&, const StepReport&)> look;
  std::function<void(const Simulation&)> end;
};

struct SampleTask {
  std::vector<Setting> settings;
  SampleRun run{};
};

class SampleEvaluator {
 public:
  // Keeps a reference to the tree. `chosen`: outputs that are columns too, the last ones.
  explicit SampleEvaluator(const ScenarioTree& tree, ChosenOutputs chosen = {});

  const ScenarioTree& tree() const { return tree_; }
  const ChosenOutputs& chosen() const { return chosen_; }
  const std::vector<ResultColumn>& columns() const { return columns_; }
  std::optional<std::size_t> find(const std::string& column) const;

  // Evaluates one sample. Another thread may set `stop`.
  SampleResult evaluate(std::span<const Setting> settings, const std::atomic<bool>& stop,
                        const SampleRun& run = {}) const;
  SampleResult evaluate(std::span<const Setting> settings) const;
  // Evaluates several samples, kSideBySide at the most, stepped side by side where that is faster (unlatch/bundle.h).
  // The results equal those of evaluations one after the other.
  static constexpr std::size_t kSideBySide = Bundle::kMost;
  std::vector<SampleResult> evaluate(std::span<const SampleTask> tasks, const std::atomic<bool>& stop) const;

 private:
  class Flight;
  static void fly_alone(Flight& flight, const std::atomic<bool>& stop);
  static std::optional<Bundle> build_bundle(std::span<Flight* const> flights);
  static void fly_together(Bundle& bundle, std::span<Flight* const> flights, const std::atomic<bool>& stop);
  std::vector<double> collect(const Scenario& scenario, const RunAnalysis& analysis) const;

  const ScenarioTree& tree_;
  const ChosenOutputs chosen_;
  const std::vector<ResultColumn> own_columns_;  // of every run
  const std::vector<ResultColumn> columns_;      // and the chosen ones
  const AnalysisRequest request_;
};

}  // namespace unlatch::hil
