// The campaign, as a part of the dossier.
#include <algorithm>
#include <cmath>

#include "tools/campaign/summary.h"
#include "tools/common/text.h"
#include "tools/unlatch/dossier/dossier_parts.h"

namespace unlatch::tools {
namespace {

constexpr std::size_t kStrongest = 5;

// The sample with the least margin of a requirement, with the command and the hashes that fly it again.
Json build_worst(const CampaignData& data, const std::string& id, const std::string& command) {
  const std::vector<double> margins = data.read_column(data.find_column(id + ".margin"));
  std::size_t worst = margins.size();
  for (std::size_t i = 0; i < margins.size(); ++i)
    if (!std::isnan(margins[i]) && (worst == margins.size() || margins[i] < margins[worst])) worst = i;
  if (worst == margins.size()) return nullptr;
  const hil::SampleRecord record = data.table->read(worst);
  return {{"sample", record.sample},
          {"margin", margins[worst]},
          {"status", hil::kSampleStatusNames[static_cast<std::size_t>(data.table->get_status(worst))]},
          {"command", command + std::to_string(record.sample)},
          {"hash", to_hex(record.result.hash)},
          {"model_hash", to_hex(record.result.model_hash)}};
}

// Inputs by the size of their influence on a requirement's value: first-order indices if the samples give them, else
// rank correlations.
Json rank_inputs(const Json& sensitivity, const Json& inputs) {
  std::vector<std::pair<double, std::size_t>> order;
  const bool has_orders = sensitivity.contains("first_order");
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : 0.0; };
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const double rho = number(sensitivity.at("spearman")[k]);
    order.emplace_back(-(has_orders ? number(sensitivity.at("first_order")[k].at("index")) : std::abs(rho)), k);
  }
  std::ranges::sort(order);
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min(kStrongest, order.size()); ++i) {
    const std::size_t k = order[i].second;
    Json item = {{"input", inputs[k].at("name")}, {"spearman", sensitivity.at("spearman")[k]}};
    if (has_orders) item["first_order"] = sensitivity.at("first_order")[k];
    list.push_back(std::move(item));
  }
  return list;
}

const Json* find_column(const Json& summary, const std::string& name) {
  for (const Json& column : summary.at("columns"))
    if (column.at("name") == name) return &column;
  return nullptr;
}

// Only what a reader of the dossier needs; all of it is in summary.json of the folder.
Json build_requirement(const CampaignData& data, const Json& summary, const Json& one, const std::string& command) {
  Json item = one;
  for (const char* left_out : {"convergence"}) item.erase(left_out);
  item["worst"] = build_worst(data, one.at("id"), command);
  if (const Json* const column = find_column(summary, one.at("id")); column != nullptr && summary.contains("inputs")) {
    item["sensitivity"] = column->at("sensitivity");
    item["strongest"] = rank_inputs(column->at("sensitivity"), summary.at("inputs"));
  }
  return item;
}

Json build_inputs(const CampaignData& data, const Json& summary) {
  Json list = Json::array();
  if (!summary.contains("inputs")) return list;
  const Json& parameters = data.manifest.at("parameters");
  for (const Json& input : summary.at("inputs")) {
    Json item = input;
    const std::string name = input.at("name");
    for (const Json& parameter : parameters) {
      const std::string own = parameter.at("name");
      if (name == own || (parameter.at("numbers") == 3 && name.starts_with(own + ".")))
        item["paths"] = parameter.at("paths");
    }
    list.push_back(std::move(item));
  }
  return list;
}

}  // namespace

Json build_campaign_part(const CampaignData& data, const std::string& command, Evidence& evidence) {
  const Json summary = build_summary(data);
  Json json = {{"name", summary.at("campaign")},         {"sampling", data.manifest.at("sampling")},
               {"seed", data.manifest.at("seed")},       {"samples", summary.at("samples")},
               {"planned", summary.at("planned")},       {"hash", summary.at("hash")},
               {"program", data.manifest.at("program")}, {"confidence", summary.at("confidence")},
               {"statuses", summary.at("statuses")},     {"unresolved", summary.at("unresolved")},
               {"requirements", Json::array()}};
  for (const Json& one : summary.at("requirements"))
    json["requirements"].push_back(build_requirement(data, summary, one, command));
  for (const char* part : {"any_requirement", "basis", "step", "rare"})
    if (summary.contains(part)) json[part] = summary.at(part);
  json["inputs"] = build_inputs(data, summary);
  json["campaign_text"] = data.manifest.at("campaign_text");
  const auto samples = summary.at("samples").get<long long>();
  evidence["uncertainty"].push_back(
      "Campaign " + summary.at("campaign").get<std::string>() + ": " + count(samples, "sample") + " of " +
      count(json.at("inputs").size(), "dispersed input") +
      (summary.at("basis").at("draws").is_null() ? "" : "; probabilities with bounds of 95 %") + ".");
  if (const std::string basis = summary.at("basis").at("text"); !basis.empty())
    evidence["uncertainty"].push_back("Sampling " + data.manifest.at("sampling").get<std::string>() + ": " + basis +
                                      ".");
  evidence["robustness"].push_back(
      "Sensitivities of every requirement to every dispersed input, from the same samples.");
  for (const Json& one : summary.at("requirements"))
    if (one.contains("without_blow"))
      evidence["uncertainty"].push_back("The values of " + one.at("id").get<std::string>() + " in " +
                                        count(one.at("without_blow").get<long long>(), "sample") +
                                        " are without the impulse of a blow through the joint.");
  for (const Json& one : summary.at("requirements"))
    if (one.contains("uncertain"))
      evidence["uncertainty"].push_back(one.at("id").get<std::string>() + ": " +
                                        count(one.at("uncertain").at("samples").get<long long>(), "sample") +
                                        " known to ± " + to_short_text(one.at("uncertain").at("by").get<double>()) +
                                        " " + one.value("unit", "") + " at worst, between steps.");
  if (!summary.at("unresolved").empty())
    evidence["uncertainty"].push_back(count(summary.at("unresolved").size(), "sample") +
                                      " unresolved: the bounds of probabilities hold whatever they are.");
  return json;
}

}  // namespace unlatch::tools
