#include "hil/study/campaign/samples/rare_failure.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/text/suggestion.h"
#include "hil/study/campaign/campaign_reader.h"
#include "hil/study/evaluation/results.h"

namespace unlatch::hil {

SubsetPlan make_subset_plan(const RareFailure& failure, const SamplingPlan& plan) {
  return {plan.seed, failure.samples, failure.chains, failure.levels, plan.dimensions};
}

double calc_failure_margin(const RareFailure& failure, SampleStatus status, double value) {
  if (status != SampleStatus::kDone || std::isnan(value)) return -HUGE_VAL;
  return failure.above ? failure.limit - value : value - failure.limit;
}
double calc_failure_margin(const RareFailure& failure, const SampleRecord& record) {
  return calc_failure_margin(failure, record.result.status, record.result.values.at(failure.column_index));
}

// Reads the column of the results and its limit. A requirement without a given limit uses its own: margin below 0.
void CampaignReader::read_failure(YamlMap& map, RareFailure& to) {
  const YamlNode* const of = map.require("of");
  const YamlNode *const below = map.find("below"), *const above = map.find("above");
  if (of == nullptr) return;
  if (below != nullptr && above != nullptr)
    mistakes_.add(above->mark, "below and above", "one limit: the other failure is a campaign of its own");
  const std::string name = read_text(*of, mistakes_);
  const std::vector<ResultColumn> columns = list_columns(campaign_.tree->get_nominal(), campaign_.chosen);
  const bool own_limit = below == nullptr && above == nullptr;
  to.column = name + (own_limit ? ".margin" : "");
  const auto at = std::find_if(columns.begin(), columns.end(),
                               [&](const ResultColumn& column) { return column.name == to.column; });
  if (at == columns.end()) {
    std::vector<std::string> known;
    for (const ResultColumn& column : columns)
      if (!own_limit || column.kind == ResultColumn::Kind::kRequirement) known.push_back(column.name);
    return mistakes_.add(
        of->mark,
        own_limit ? "no requirement '" + name + "', and no limit" : "no result '" + name + "' of this scenario",
        (own_limit ? "a requirement, or add below or above; " : "") + suggest(name, known));
  }
  to.column_index = static_cast<std::size_t>(at - columns.begin());
  to.unit = at->unit;
  to.above = above != nullptr;
  if (!own_limit) to.limit = read_number(above != nullptr ? *above : *below, at->unit, 0.0, mistakes_);
}

void CampaignReader::read_subset(YamlMap& top) {
  const YamlNode* const node = top.find("subset");
  SamplingPlan& plan = campaign_.plan;
  if (plan.sampling != Sampling::kSubset) {
    if (node != nullptr)
      mistakes_.add(node->mark, "a rare failure without `sampling: subset`", "add that, or leave subset out");
    return;
  }
  if (node == nullptr) {
    top.require("subset");
    return;
  }
  YamlMap map(*node, "subset", mistakes_);
  RareFailure& failure = campaign_.failure.emplace();
  read_failure(map, failure);
  const double part = map.number("part", "", 0.1), levels = map.number("levels", "", 8.0);
  failure.at_most = map.number("at_most", "", 1.0);
  map.finish();
  constexpr double kMostLevels = 50;
  if (!(levels >= 1 && levels <= kMostLevels && levels == std::floor(levels)))
    mistakes_.add(map.node().find("levels")->mark, "this number of levels is not usable",
                  "a whole number from 1 to 50");
  if (!(failure.at_most > 0 && failure.at_most <= 1))
    mistakes_.add(map.node().find("at_most")->mark, "this probability is not usable", "above 0, at most 1");
  const double chains = std::round(part * static_cast<double>(plan.samples));
  constexpr double kWhole = 1e-9;
  const auto is_whole = [](double x) { return std::abs(x - std::round(x)) <= kWhole * x; };
  if (!(part > 0 && part <= 0.5 && is_whole(1 / part)))
    mistakes_.add(map.node().find("part")->mark, "this part is not usable", "one half, a third, … such as 0.1 or 25 %");
  else if (plan.samples > 0 && !is_whole(part * static_cast<double>(plan.samples)))
    mistakes_.add(node->mark, "this part of the samples of a level is no whole number",
                  "samples: a multiple of " + to_text(std::round(1 / part)));
  if (mistakes_.count() > 0 || plan.samples == 0) return;
  failure.samples = plan.samples;
  failure.chains = static_cast<std::int64_t>(chains);
  failure.levels = static_cast<int>(levels);
  plan.samples = make_subset_plan(failure, plan).get_most_samples();
}

}  // namespace unlatch::hil
