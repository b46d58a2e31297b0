// One sample of a scenario, in this process: settings in, results out. The way of campaigns, optimisation and batches.
//
//   const ScenarioTree tree("boosters/reference.yaml");      // parsed once
//   const SampleEvaluator evaluator(tree);                    // threads may share both
//   const Setting settings[] = {make_setting("bodies.core.mass", 98000.0)};
//   const SampleResult result = evaluator.evaluate(settings);
//   result.values[*evaluator.find("distance1")]
//
// A result depends on the scenario and the settings alone, to the last bit that of `unlatch run --set`: nothing is kept
// from one sample to the next.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/evaluation/results.h"
#include "hil/language/setting.h"
#include "hil/messages/messages.h"
#include "hil/scenario/scenario_tree.h"
#include "unlatch/bundle.h"

namespace unlatch::hil {

enum class SampleStatus {
  kDone,         // ran to its end
  kFaulted,      // the step failed: `message` says at which joint and tick; the values are those until then
  kInvalid,      // the settings make no valid scenario: `message` has all mistakes; no values
  kInterrupted,  // `stop` ended it: no result
};
extern const std::vector<std::string> kSampleStatusNames;  // "done" …, in this order

struct SampleResult {
  SampleStatus status = SampleStatus::kDone;
  std::string message;
  std::int64_t ticks = 0;       // of the last good state
  std::int64_t hash = 0;        // of that state, as `run` tells it
  std::int64_t model_hash = 0;  // of model, plan and rates: that of loading the file anew with the same values
  std::vector<double> values;   // one for each column
};

// How a sample is run, where that is not as the scenario says.
struct SampleRun {
  double until = 0;    // s; 0: the scenario's end
  bool judges = true;  // false: no values, and a run at the speed of the step
  // Called at every tick, the first included, with what its step reported; and at the end, with the last good state.
  // A ScenarioError that they throw makes the sample invalid. They may be empty.
  std::function<void(const Scenario&, const Simulation&, const StepReport&)> look;
  std::function<void(const Simulation&)> end;
};

struct SampleTask {
  std::vector<Setting> settings;
  SampleRun run{};
};

class SampleEvaluator {
 public:
  // Refers to the tree.
  explicit SampleEvaluator(const ScenarioTree& tree);

  const ScenarioTree& tree() const { return tree_; }
  const std::vector<ResultColumn>& columns() const { return columns_; }
  std::optional<std::size_t> find(const std::string& column) const;

  // Another thread may set `stop`.
  SampleResult evaluate(std::span<const Setting> settings, const std::atomic<bool>& stop,
                        const SampleRun& run = {}) const;
  SampleResult evaluate(std::span<const Setting> settings) const;
  // Of several samples, stepped side by side where that gains (unlatch/bundle.h), kSideBySide at the most: their
  // results are those of one after the other.
  static constexpr std::size_t kSideBySide = Bundle::kMost;
  std::vector<SampleResult> evaluate(std::span<const SampleTask> tasks, const std::atomic<bool>& stop) const;

 private:
  class Flight;
  static void fly_alone(Flight& flight, const std::atomic<bool>& stop);
  static std::optional<Bundle> build_bundle(std::span<Flight* const> flights);
  static void fly_together(Bundle& bundle, std::span<Flight* const> flights, const std::atomic<bool>& stop);
  std::vector<double> collect(const Scenario& scenario, const RunAnalysis& analysis) const;

  const ScenarioTree& tree_;
  const std::vector<ResultColumn> columns_;
  const AnalysisRequest request_;
};

}  // namespace unlatch::hil
