#include "tools/campaign/failures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "hil/scenario/yaml/setting.h"
#include "hil/study/evaluation/results.h"
#include "hil/study/sampling/subset.h"
#include "hil/study/statistics/statistics.h"
#include "tools/campaign/column_statistics.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

constexpr std::size_t kWorst = 10;

// A sample fails a requirement that it does not meet, cannot be judged by, or does not live to be judged by.
bool fails(hil::SampleStatus status, double margin) { return status != hil::SampleStatus::kDone || !(margin >= 0); }

// Bounds of a probability if unresolved samples may have failed or not: the lower bound counts none of them, the upper
// one all.
hil::Interval calc_bounds(std::int64_t failed, std::int64_t unresolved, std::int64_t count) {
  return {hil::calc_clopper_pearson(failed, count).low, hil::calc_clopper_pearson(failed + unresolved, count).high};
}

// The part of the resolved samples that failed; null without any.
Json calc_estimate(std::int64_t failed, std::int64_t unresolved, std::int64_t count) {
  return count > unresolved ? Json(static_cast<double>(failed) / static_cast<double>(count - unresolved))
                            : Json(nullptr);
}

}  // namespace

namespace {

struct Counts {
  std::int64_t failed = 0, unjudged = 0, unresolved = 0, samples = 0, faulted = 0;
};

void describe_probability(const Counts& counts, Json& json) {
  json["estimate"] = calc_estimate(counts.failed, counts.unresolved, counts.samples);
  json["probability"] = to_json(calc_bounds(counts.failed, counts.unresolved, counts.samples));
}

Counts count_any(const CampaignData& data) {
  std::vector<std::vector<double>> margins;
  for (const Json& requirement : data.manifest.at("requirements"))
    margins.push_back(data.read_column(data.find_column(requirement.at("id").get<std::string>() + ".margin")));
  Counts counts;
  counts.samples = static_cast<std::int64_t>(data.rows);
  for (std::size_t row = 0; row < data.rows; ++row) {
    const hil::SampleStatus status = data.get_status(row);
    if (status == hil::SampleStatus::kUnresolved) {
      ++counts.unresolved;
      continue;
    }
    counts.failed +=
        std::ranges::any_of(margins, [&](const auto& column) { return fails(status, column[row]); }) ? 1 : 0;
  }
  return counts;
}

Counts count_failures(const CampaignData& data, const std::vector<double>& margins) {
  Counts counts;
  counts.samples = static_cast<std::int64_t>(data.rows);
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (data.get_status(row) == hil::SampleStatus::kUnresolved) {
      ++counts.unresolved;
      continue;
    }
    counts.failed += fails(data.get_status(row), margins[row]) ? 1 : 0;
    const bool done = data.get_status(row) == hil::SampleStatus::kDone;
    counts.unjudged += done && std::isnan(margins[row]) ? 1 : 0;
    counts.faulted += done ? 0 : 1;
  }
  return counts;
}

// Quantiles and tolerance limits of the values of draws.
void describe_values(const std::vector<double>& values, Json& json) {
  const std::vector<double> sorted = sort_present(values);
  add_quantiles(sorted, json);
  const std::size_t without_value = values.size() - sorted.size();
  // Samples without a value are no chance choice: the others say nothing of all runs.
  if (without_value > 0) json["intervals"] = Json::object();
  // The least and the greatest value that at least 99 % of all runs keep to, with the confidence.
  constexpr double kCoverage = 0.99;
  const std::int64_t rank = hil::calc_wilks_rank(static_cast<std::int64_t>(sorted.size()), kCoverage);
  json["tolerance"] = {
      {"coverage", kCoverage}, {"samples_needed", hil::calc_wilks_trials(kCoverage)}, {"without_value", without_value}};
  if (rank > 0 && without_value == 0) {
    json["tolerance"]["lower"] = sorted[static_cast<std::size_t>(rank - 1)];
    json["tolerance"]["upper"] = sorted[sorted.size() - static_cast<std::size_t>(rank)];
  }
}

// Estimate and bounds of the probability after the first samples.
Json list_convergence(const CampaignData& data, const std::vector<double>& margins) {
  Json list = Json::array();
  std::int64_t hits = 0, open = 0;
  double next = 10;
  const auto count = static_cast<std::int64_t>(data.rows);
  for (std::int64_t i = 0; i < count; ++i) {
    const auto row = static_cast<std::size_t>(i);
    const bool resolved = data.get_status(row) != hil::SampleStatus::kUnresolved;
    open += resolved ? 0 : 1;
    hits += resolved && fails(data.get_status(row), margins[row]) ? 1 : 0;
    if (static_cast<double>(i + 1) < next && i + 1 < count) continue;
    const hil::Interval bounds = calc_bounds(hits, open, i + 1);
    list.push_back({i + 1, calc_estimate(hits, open, i + 1), bounds.low, bounds.high});
    next *= 1.25;
  }
  return list;
}

}  // namespace

Json describe_any_failure(const CampaignData& data, const std::optional<CampaignData>& population) {
  const Counts counts = count_any(data);
  Json json = {
      {"failed", counts.failed}, {"unresolved", counts.unresolved}, {"estimate", nullptr}, {"probability", nullptr}};
  if (population) describe_probability(count_any(*population), json);
  return json;
}

Json list_unresolved(const CampaignData& data) {
  Json samples = Json::array();
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.get_status(row) == hil::SampleStatus::kUnresolved) samples.push_back(data.get_sample(row));
  return samples;
}

Json count_blows(const CampaignData& data) {
  Json counts = Json::object();
  const Json& columns = data.manifest.at("columns");
  for (std::size_t column = 0; column < columns.size(); ++column) {
    if (columns[column].at("kind") != "without_blow") continue;
    const std::vector<double> times = data.read_results(column);
    const auto number = std::ranges::count_if(times, [](double time) { return !std::isnan(time); });
    const std::string name = columns[column].at("name");
    if (number > 0) counts[name.substr(0, name.rfind('.'))] = number;
  }
  return counts;
}

Json count_uncertain(const CampaignData& data) {
  Json counts = Json::object();
  const Json& columns = data.manifest.at("columns");
  for (std::size_t column = 0; column < columns.size(); ++column) {
    if (columns[column].at("kind") != "uncertainty") continue;
    const std::vector<double> sorted = sort_present(data.read_results(column));
    const std::string name = columns[column].at("name");
    if (!sorted.empty()) counts[name.substr(0, name.rfind('.'))] = {{"samples", sorted.size()}, {"by", sorted.back()}};
  }
  return counts;
}

Json describe_requirement(const CampaignData& data, const std::optional<CampaignData>& population,
                          const Json& requirement) {
  const std::string id = requirement.at("id");
  const std::size_t margin = data.find_column(id + ".margin"), value = data.find_column(id);
  const Counts counts = count_failures(data, data.read_column(margin));
  Json json = requirement;
  json["failed"] = counts.failed;
  json["not_evaluated"] = counts.unjudged;  // of samples that ran to their end; counted as failed
  json["faulted"] = counts.faulted;         // counted as failed, too
  json["unresolved"] = counts.unresolved;   // neither met nor missed: the bounds hold whatever they are
  const std::vector<double> sorted = sort_present(data.read_results(value));
  json["min"] = sorted.empty() ? Json(nullptr) : to_json(sorted.front());
  json["max"] = sorted.empty() ? Json(nullptr) : to_json(sorted.back());
  json["estimate"] = nullptr;
  json["probability"] = nullptr;
  json["convergence"] = Json::array();
  if (!population) {
    add_no_quantiles(json);
    json["tolerance"] = nullptr;
    return json;
  }
  const std::vector<double> margins = population->read_column(margin);
  describe_probability(count_failures(*population, margins), json);
  describe_values(population->read_results(value), json);
  json["convergence"] = list_convergence(*population, margins);
  return json;
}

Json list_worst(const CampaignData& data) {
  std::vector<double> least(data.rows);
  for (std::size_t row = 0; row < data.rows; ++row)
    least[row] = data.get_status(row) == hil::SampleStatus::kDone ? HUGE_VAL : -HUGE_VAL;
  const auto take = [&](const std::vector<double>& margins) {
    const std::vector<double> sorted = sort_present(margins);
    const double spread = hil::calc_quantile(sorted, 0.9) - hil::calc_quantile(sorted, 0.1);
    for (std::size_t i = 0; i < margins.size(); ++i) {
      const double scaled = std::isnan(margins[i]) ? -HUGE_VAL : spread > 0 ? margins[i] / spread : margins[i];
      least[i] = std::min(least[i], scaled);
    }
  };
  for (const Json& requirement : data.manifest.at("requirements"))
    take(data.read_column(data.find_column(requirement.at("id").get<std::string>() + ".margin")));
  if (const auto failure = data.get_failure()) take(data.read_failure_margins(*failure));
  std::vector<std::size_t> order(data.rows);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t count = std::min(kWorst, order.size());
  std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(count), {},
                            [&](std::size_t row) { return std::pair(least[row], row); });
  Json worst = Json::array();
  for (std::size_t i = 0; i < count; ++i) worst.push_back(data.get_sample(order[i]));
  return worst;
}

// Names of the inputs of few values (discrete ones, flags) of which a failed sample has one that no independent sample
// of level 0 had: how probable the failure is with it, the levels do not say.
std::vector<std::string> list_unseen(const CampaignData& data, const std::vector<double>& margins) {
  const CampaignData drawn = data.get_drawn();
  std::vector<std::string> names;
  std::size_t input = 0;
  for (const Json& parameter : data.manifest.at("parameters"))
    for (std::size_t k = 0; k < parameter.at("numbers").get<std::size_t>(); ++k, ++input) {
      std::vector<double> seen = drawn.read_input(input);
      const std::size_t all = seen.size();
      std::ranges::sort(seen);
      seen.erase(std::ranges::unique(seen).begin(), seen.end());
      if (2 * seen.size() > all) continue;  // continuous
      const std::vector<double> values = data.read_input(input);
      bool is_unseen = false;
      for (std::size_t row = 0; row < data.rows && !is_unseen; ++row)
        is_unseen = margins[row] < 0 && !std::ranges::binary_search(seen, values[row]);
      const std::string name = parameter.at("name");
      if (is_unseen && (names.empty() || names.back() != name)) names.push_back(name);
    }
  return names;
}

Json describe_rare(const CampaignData& data, const hil::RareFailure& failure) {
  hil::SamplingPlan plan;
  plan.seed = data.manifest.at("seed");
  for (const Json& parameter : data.manifest.at("parameters"))
    plan.dimensions += parameter.at("axes").get<std::size_t>();
  hil::SubsetSimulation subset(make_subset_plan(failure, plan));
  std::int64_t failed = 0;
  const std::vector<double> margins = data.read_failure_margins(failure);
  std::int64_t unresolved = 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    subset.note(data.get_sample(row), margins[row]);
    const bool open = data.get_status(row) == hil::SampleStatus::kUnresolved;
    unresolved += open ? 1 : 0;
    failed += !open && margins[row] < 0 ? 1 : 0;
  }
  const hil::SubsetEstimate estimate = subset.calc_estimate();
  Json json = data.manifest.at("subset");
  json.erase("column_index");
  json["finished"] = subset.is_finished();
  json["reached"] = estimate.reached;
  json["tied"] = estimate.tied;
  // The levels take unresolved samples for failures, so that only the upper bound holds where there are any.
  const std::vector<std::string> unseen = list_unseen(data, margins);
  const bool known = estimate.decided && unresolved == 0 && unseen.empty();
  json["decided"] = known;
  json["unseen"] = unseen;
  json["probability"] = known ? to_json(estimate.probability) : Json(nullptr);
  json["deviation"] = known ? to_json(estimate.deviation) : Json(nullptr);
  json["interval"] = {unresolved == 0 ? estimate.low : 0.0, estimate.high};
  if (!unseen.empty()) {  // the independent samples alone bound it
    const hil::Interval bounds = subset.calc_first_bounds();
    json["interval"] = {unresolved == 0 ? bounds.low : 0.0, bounds.high};
  }
  json["met"] = known && estimate.reached && estimate.high <= failure.at_most;
  json["failed_samples"] = failed;
  json["unresolved_samples"] = unresolved;
  json["levels_run"] = Json::array();
  json["curve"] = Json::array();
  double before = 1;
  for (const hil::SubsetLevel& level : subset.levels()) {
    json["levels_run"].push_back({{"first", level.first},
                                  {"last", level.last},
                                  {"threshold", to_json(level.threshold)},
                                  {"failed", level.failed},
                                  {"probability", level.probability},
                                  {"deviation", to_json(level.deviation)},
                                  {"acceptance", level.acceptance},
                                  {"spread", level.spread}});
    // The margins of a level above its threshold; those below it are better known from the next.
    const std::size_t count = level.margins.size(), every = std::max<std::size_t>(1, count / 100);
    const bool last = &level == &subset.levels().back();
    for (std::size_t k = count; k-- > 0;) {
      if (k % every != 0 || !std::isfinite(level.margins[k])) continue;
      if (!last && level.margins[k] <= level.threshold) break;
      json["curve"].push_back({level.margins[k], before * static_cast<double>(k + 1) / static_cast<double>(count)});
    }
    before *= level.probability;
  }
  return json;
}

std::string describe_rare_failure(const Json& rare) {
  return rare.at("column").get<std::string>() + (rare.at("above").get<bool>() ? " above " : " below ") +
         hil::to_text(rare.at("limit").get<double>()) + " " + rare.at("unit").get<std::string>();
}

RareResult describe_rare_result(const Json& rare) {
  if (!rare.at("finished").get<bool>()) return {"not finished", ""};
  const double most = rare.at("interval")[1].get<double>();
  if (const auto unresolved = rare.at("unresolved_samples").get<long long>(); unresolved > 0)
    return {format("probability at most %.2e (95 %%)", most) + ", without an estimate: " +
                count(unresolved, "unresolved sample") + (unresolved == 1 ? " is" : " are") + " taken for a failure",
            ""};
  if (!rare.at("unseen").empty()) {
    std::string names;
    for (const Json& name : rare.at("unseen")) names += (names.empty() ? "" : ", ") + name.get<std::string>();
    return {format("undecided: probability at most %.2e (95 %%), without an estimate: failures have values of %s", most,
                   names.c_str()) +
                " that none of the independent samples has: more samples",
            ""};
  }
  if (!rare.at("decided").get<bool>()) {
    const long long failed = rare.at("levels_run").back().at("failed").get<long long>();
    return {format("undecided: probability at most %.2e (95 %%), without an estimate: %lld of the last level fail",
                   most, failed) +
                (rare.at("tied").get<bool>()
                     ? ", and so many of the others have the same margin that no level leads further: more samples, or "
                       "another column whose values differ"
                     : ": more levels"),
            ""};
  }
  return {format("probability %.3g, 95 %%: %.2e … %.2e", rare.at("probability").get<double>(),
                 rare.at("interval")[0].get<double>(), most),
          ", coefficient of variation " +
              (rare.at("deviation").is_null() ? std::string("–") : format("%.2f", rare.at("deviation").get<double>())) +
              (rare.at("reached").get<bool>() ? ""
               : rare.at("tied").get<bool>()  ? "; few samples fail, and no level leads further: more samples"
                                              : "; the last level had too few failures: more levels")};
}

}  // namespace unlatch::tools
