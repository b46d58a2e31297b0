#include "hil/study/campaign/samples/campaign_step.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "hil/study/campaign/campaign_reader.h"
#include "hil/study/evaluation/step_settings.h"

namespace unlatch::hil {
namespace {

constexpr std::int64_t kCorners = 8, kDraws = 8;
constexpr int kMostHalvings = 5;

// Corners of what may be drawn, and samples from the whole campaign; of a table rows alone.
std::vector<StepFlight> list_flights(const Campaign& campaign) {
  std::vector<StepFlight> flights;
  if (campaign.plan.sampling != Sampling::kCsv)
    for (std::int64_t i = 0; i < kCorners; ++i)
      flights.push_back(
          {"corner " + std::to_string(i),
           make_settings(campaign, calc_inputs(campaign, draw_corner(campaign, static_cast<std::uint64_t>(i))))});
  const std::int64_t drawn = campaign.failure ? campaign.failure->samples : campaign.plan.samples;
  const std::int64_t count = std::min(drawn, kDraws);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t sample = i * (drawn / count);
    flights.push_back({"sample " + std::to_string(sample), make_settings(campaign, draw_inputs(campaign, sample))});
  }
  return flights;
}

JudgedValues list_judged(const Campaign& campaign, const SampleEvaluator& evaluator) {
  if (campaign.failure) return JudgedValues(evaluator, {campaign.failure->column_index});
  return JudgedValues(evaluator);
}

std::size_t find_column(const SampleEvaluator& evaluator, ResultColumn::Kind kind) {
  const auto at = std::ranges::find(evaluator.columns(), kind, &ResultColumn::kind);
  return static_cast<std::size_t>(at - evaluator.columns().begin());
}

}  // namespace

StepSearch search_step(const Campaign& campaign, double tolerance, int jobs, const std::atomic<bool>& stop) {
  const SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
  return find_step(evaluator, list_judged(campaign, evaluator), list_flights(campaign), tolerance, jobs, stop);
}

bool choose_step(Campaign& campaign, int jobs, const std::atomic<bool>& stop) {
  if (!(campaign.tolerance > 0)) return true;
  campaign.step_search = search_step(campaign, campaign.tolerance, jobs, stop);
  if (!campaign.step_search->step) return false;
  set_step(campaign, *campaign.step_search->step);
  return true;
}

void set_step(Campaign& campaign, double step) {
  std::vector<std::string> overrides = campaign.tree->get_nominal().overrides;
  for (const Setting& setting : make_step_settings(campaign.tree->get_nominal(), step))
    overrides.push_back(to_text(setting));
  campaign.tree = std::make_shared<ScenarioTree>(campaign.scenario, overrides);
}

void check_step(const Campaign& campaign, const SampleEvaluator& evaluator, const std::atomic<bool>& stop,
                SampleRecord& record) {
  const bool is_open = record.result.status == SampleStatus::kUnresolved;
  const bool is_checked = record.sample % kCheckedEvery == 0 && record.result.status == SampleStatus::kDone;
  if (!is_open && !is_checked) return;
  const JudgedValues judged = list_judged(campaign, evaluator);
  const std::vector<Setting> settings = make_settings(campaign, record.inputs);
  const std::size_t error_column = find_column(evaluator, ResultColumn::Kind::kStepError);
  std::string history;
  double error = 0;
  for (int halving = 0;; ++halving) {
    const double step = get_step(evaluator, record);
    const std::optional<double> half = halve_step(step);
    if (!half || halving > kMostHalvings) break;
    std::vector<Setting> finer = settings;
    std::ranges::move(make_step_settings(campaign.tree->get_nominal(), *half), std::back_inserter(finer));
    SampleResult result = evaluator.evaluate(finer, stop);
    if (result.status == SampleStatus::kInterrupted) {
      record.result = std::move(result);
      return;
    }
    if (result.status == SampleStatus::kInvalid) break;
    const JudgedValues::Difference difference = judged.compare(record.result, result);
    error = 2 * difference.size;  // halving at least halves the error
    if (error <= campaign.tolerance) {
      record.result.values[error_column] = error;
      if (!history.empty()) record.result.message += (record.result.message.empty() ? "" : "; ") + history;
      return;
    }
    if (history.empty())
      history = "flown again finer: at " + to_text(step) + " s " + difference.of + " is off by " + to_text(error);
    record.result = std::move(result);
  }
  record.result.values[error_column] = error;  // at twice this step
  record.result.status = SampleStatus::kUnresolved;
  record.result.message = "no step meets the tolerance; " + history;
}

double get_step(const SampleEvaluator& evaluator, const SampleRecord& record) {
  return record.result.values[find_column(evaluator, ResultColumn::Kind::kStep)];
}

}  // namespace unlatch::hil
