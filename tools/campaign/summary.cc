#include "tools/campaign/summary.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/study/sampling/sampling.h"
#include "hil/study/statistics/statistics.h"
#include "tools/campaign/column_statistics.h"
#include "tools/campaign/event_orders.h"
#include "tools/campaign/failures.h"
#include "tools/campaign/sensitivity.h"
#include "tools/campaign/steps.h"
#include "tools/common/text.h"

namespace unlatch::tools {

Json build_summary(const CampaignData& all) {
  const CampaignData data = all.get_drawn();
  Json statuses = Json::object();
  for (const std::string& name : hil::kSampleStatusNames) statuses[name] = 0;
  statuses.erase("interrupted");
  for (std::size_t row = 0; row < all.rows; ++row) {
    Json& count = statuses[hil::kSampleStatusNames[static_cast<std::size_t>(all.get_status(row))]];
    count = count.get<std::int64_t>() + 1;
  }
  Json summary = {{"schema", 1},
                  {"campaign", data.manifest.at("campaign")},
                  {"scenario", data.manifest.at("scenario")},
                  {"samples", all.rows},
                  {"planned", data.manifest.at("samples")},
                  {"hash", to_hex(data.table->hash())},
                  {"confidence", hil::kConfidence},
                  {"statuses", statuses},
                  {"remarks", data.manifest.value("remarks", Json::array())},
                  {"requirements", Json::array()},
                  {"worst", list_worst(all)}};
  if (data.manifest.contains("step")) summary["step"] = describe_steps(all);
  if (const auto failure = all.get_failure()) {
    summary["drawn"] = data.rows;
    summary["rare"] = describe_rare(all, *failure);
  }
  const std::optional<CampaignData> population = all.get_population();
  const hil::Sampling sampling = all.get_sampling();
  summary["basis"] = {{"sampling", data.manifest.at("sampling")},
                      {"independent", hil::get_basis(sampling) == hil::SampleBasis::kIndependent},
                      {"draws", population ? Json(population->rows) : Json(nullptr)},
                      {"text", hil::describe_basis(sampling)}};
  // Parts of a variance by correlated inputs overlap; those of a table may be correlated.
  summary["correlated"] = data.manifest.value("correlated", false) || sampling == hil::Sampling::kCsv;
  // The three components of a direction have its two numbers.
  summary["directions"] = std::ranges::any_of(data.manifest.at("parameters"),
                                              [](const Json& parameter) { return parameter.at("numbers") != 1; });
  const Json blows = count_blows(data), uncertain = count_uncertain(data);
  for (const Json& requirement : data.manifest.at("requirements")) {
    Json described = describe_requirement(data, population, requirement);
    const std::string id = requirement.at("id");
    if (blows.contains(id)) described["without_blow"] = blows.at(id);
    if (uncertain.contains(id)) described["uncertain"] = uncertain.at(id);
    summary["requirements"].push_back(std::move(described));
  }
  if (!summary.at("requirements").empty()) summary["any_requirement"] = describe_any_failure(data, population);
  summary["unresolved"] = list_unresolved(all);
  summary["orders"] = list_orders(data);
  // Of saltelli the base rows; of chosen points all of them, without quantiles.
  const CampaignData& described = population ? *population : data;
  const bool drawn = population.has_value();
  bool all_done = true;
  for (std::size_t row = 0; row < described.rows; ++row)
    all_done = all_done && described.get_status(row) == hil::SampleStatus::kDone;
  hil::RankedVariables ranked;
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k) {
    const std::vector<double> values = described.read_input(k);
    ranked.add(values, data.manifest.at("inputs")[k].value("category", false));
    summary["inputs"].push_back(describe_column(data.manifest.at("inputs")[k], values, drawn));
  }
  for (std::size_t k = 0; k < data.count_plain_columns(); ++k) {
    const std::vector<double> values = described.read_results(k);
    Json column = describe_column(data.manifest.at("columns")[k], values, drawn);
    if (!all_done) column["intervals"] = Json::object();  // the others are no chance choice
    column["kind"] = data.manifest.at("columns")[k].at("kind");
    column["sensitivity"] = describe_sensitivity(data, ranked, values, k);
    summary["columns"].push_back(std::move(column));
  }
  if (data.manifest.contains("curves"))
    for (const Json& curve : data.manifest.at("curves"))
      summary["curves"].push_back(describe_curve(described, curve, drawn));
  return summary;
}

}  // namespace unlatch::tools
