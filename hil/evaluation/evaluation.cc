#include "hil/evaluation/evaluation.h"

#include <limits>

#include "hil/run/run.h"

namespace unlatch::hil {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

}  // namespace

const std::vector<std::string> kSampleStatusNames{"done", "faulted", "invalid", "interrupted"};

SampleEvaluator::SampleEvaluator(const ScenarioTree& tree)
    : tree_(tree), columns_(list_columns(tree.get_nominal())), request_(list_needs(columns_)) {}

std::optional<std::size_t> SampleEvaluator::find(const std::string& column) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].name == column) return i;
  return std::nullopt;
}

// Settings may take events out (enabled: false): then columns are found by their names.
std::vector<double> SampleEvaluator::collect(const Scenario& scenario, const RunAnalysis& analysis) const {
  const std::vector<ResultColumn> own = list_columns(scenario);
  std::vector<double> values = collect_results(own, scenario, analysis);
  if (own == columns_) return values;
  std::vector<double> by_name(columns_.size(), kNothing);
  for (std::size_t i = 0; i < own.size(); ++i)
    if (const auto column = find(own[i].name)) by_name[*column] = values[i];
  return by_name;
}

SampleResult SampleEvaluator::evaluate(std::span<const Setting> settings, const std::atomic<bool>& stop,
                                       const SampleRun& run) const {
  SampleResult result;
  try {
    const Scenario scenario = tree_.read(settings);
    const auto simulation = build_simulation(scenario);
    std::optional<RunAnalysis> analysis;
    if (run.judges) analysis.emplace(scenario, *simulation, request_);
    const std::int64_t last = calc_nearest_tick(run.until > 0 ? run.until : scenario.until, scenario.dt);
    const LogEnd end =
        run_fast(*simulation, analysis ? &*analysis : nullptr, nullptr, last, stop, [&](const StepReport& report) {
          if (run.look) run.look(scenario, *simulation, report);
        });
    if (run.end) run.end(*simulation);
    if (end.status == RunStatus::kAborted) result.status = SampleStatus::kInterrupted;
    if (end.status == RunStatus::kFaulted) result.status = SampleStatus::kFaulted;
    result.message = end.message;
    result.ticks = end.tick;
    result.hash = end.hash;
    result.model_hash = simulation->get_model_hash();
    result.values = analysis ? collect(scenario, *analysis) : std::vector<double>(columns_.size(), kNothing);
  } catch (const ScenarioError& error) {
    result.status = SampleStatus::kInvalid;
    result.message = error.what();
    result.values.assign(columns_.size(), kNothing);
  }
  return result;
}

SampleResult SampleEvaluator::evaluate(std::span<const Setting> settings) const {
  const std::atomic<bool> never{false};
  return evaluate(settings, never);
}

}  // namespace unlatch::hil
