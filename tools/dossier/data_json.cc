#include "tools/dossier/data_json.h"

#include <filesystem>

#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;
using Role = hil::DataValue::Role;

constexpr const char* kFollows = "follows";

// Basis of a value in a word: that of its entry, "follows" from constants, "none".
std::string get_word(const hil::ScenarioRecord& record, const hil::DataValue& value) {
  if (value.basis >= 0)
    return hil::kBasisNames[static_cast<std::size_t>(record.basis[static_cast<std::size_t>(value.basis)].kind)];
  return value.follows() ? kFollows : "none";
}

Json to_json(const BasisCounts& counts) {
  Json json = {{"all", counts.all}, {"none", counts.none}, {kFollows, counts.follow}};
  for (std::size_t i = 0; i < hil::kBasisNames.size(); ++i) json[hil::kBasisNames[i]] = counts.of_kinds[i];
  json["with_uncertainty"] = counts.uncertain;
  return json;
}

Json build_value(const hil::Scenario& scenario, const hil::ScenarioRecord& record, const hil::DataValue& value) {
  Json item = {{"path", value.path},
               {"text", value.text},
               {"unit", value.unit},
               {"numbers", value.numbers},
               {"role", value.role == Role::kInput ? "input" : "model"},
               {"basis", get_word(record, value)}};
  if (value.basis >= 0) {
    const hil::Basis& basis = record.basis[static_cast<std::size_t>(value.basis)];
    if (basis.uncertainty)
      item["uncertainty"] = {{"text", basis.uncertainty_text}, {"sizes", calc_uncertainties(value, record.basis)}};
    if (!basis.source.empty()) item["source"] = basis.source;
  }
  if (!value.constants.empty()) item["constants"] = value.constants;
  item["place"] = value.mark.line == 0
                      ? value.mark.override_index >= 0 ? "--set" : ""
                      : get_name_from_folder(scenario, value.mark.file) + ":" + std::to_string(value.mark.line);
  return item;
}

}  // namespace

std::string get_name_from_folder(const hil::Scenario& scenario, int file) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(scenario.file).parent_path();
  const fs::path path = scenario.files.at(static_cast<std::size_t>(file));
  return (folder.empty() ? path : path.lexically_relative(folder)).generic_string();
}

BasisCounts count_basis(const hil::ScenarioRecord& record, Role role) {
  BasisCounts counts;
  counts.of_kinds.resize(hil::kBasisNames.size());
  for (const hil::DataValue& value : record.values) {
    if (value.role != role) continue;
    ++counts.all;
    if (value.basis >= 0) {
      const hil::Basis& basis = record.basis[static_cast<std::size_t>(value.basis)];
      ++counts.of_kinds[static_cast<std::size_t>(basis.kind)];
      counts.uncertain += basis.uncertainty ? 1 : 0;
    } else {
      ++(value.follows() ? counts.follow : counts.none);
    }
  }
  return counts;
}

std::string describe(const BasisCounts& counts) {
  std::string kinds;
  for (std::size_t i = 0; i < counts.of_kinds.size(); ++i)
    if (counts.of_kinds[i] > 0)
      kinds += (kinds.empty() ? "" : ", ") + std::to_string(counts.of_kinds[i]) + " " + hil::kBasisNames[i];
  const std::size_t stated = counts.all - counts.follow - counts.none;
  return std::to_string(stated) + " of " + count(counts.all, "value") + (stated == 1 ? " has" : " have") + " a basis" +
         (kinds.empty() ? "" : " (" + kinds + ")") + ", " + std::to_string(counts.uncertain) +
         " of them with an uncertainty; " + std::to_string(counts.follow) +
         (counts.follow == 1 ? " follows" : " follow") + " from constants; " + std::to_string(counts.none) +
         (counts.none == 1 ? " has" : " have") + " none";
}

Json build_data_json(const hil::Scenario& scenario, const hil::ScenarioRecord& record) {
  Json json = {
      {"counts",
       {{"model", to_json(count_basis(record, Role::kModel))}, {"input", to_json(count_basis(record, Role::kInput))}}},
      {"values", Json::array()}};
  for (const hil::DataValue& value : record.values) json["values"].push_back(build_value(scenario, record, value));
  return json;
}

}  // namespace unlatch::tools
