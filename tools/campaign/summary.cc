#include "tools/campaign/summary.h"

#include <string>
#include <utility>
#include <vector>

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
    Json& count = statuses[hil::kSampleStatusNames[static_cast<std::size_t>(all.table->get_status(row))]];
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
  const Json blows = count_blows(data);
  for (const Json& requirement : data.manifest.at("requirements")) {
    Json described = describe_requirement(data, requirement);
    const std::string id = requirement.at("id");
    if (blows.contains(id)) described["without_blow"] = blows.at(id);
    summary["requirements"].push_back(std::move(described));
  }
  if (!summary.at("requirements").empty()) summary["any_requirement"] = describe_any_failure(data);
  summary["unresolved"] = list_unresolved(all);
  summary["orders"] = list_orders(data);
  hil::RankedVariables ranked;
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k) {
    const std::vector<double> values = data.read_input(k);
    ranked.add(values);
    summary["inputs"].push_back(describe_column(data.manifest.at("inputs")[k], values));
  }
  for (std::size_t k = 0; k < data.count_plain_columns(); ++k) {
    const std::vector<double> values = data.read_column(k);
    Json column = describe_column(data.manifest.at("columns")[k], values);
    column["kind"] = data.manifest.at("columns")[k].at("kind");
    column["sensitivity"] = describe_sensitivity(data, ranked, values);
    summary["columns"].push_back(std::move(column));
  }
  if (data.manifest.contains("curves"))
    for (const Json& curve : data.manifest.at("curves")) summary["curves"].push_back(describe_curve(data, curve));
  return summary;
}

}  // namespace unlatch::tools
