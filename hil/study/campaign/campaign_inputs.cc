// Conversion of a sample's number into values of the scenario.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hil/scenario/base/normal.h"
#include "hil/scenario/base/philox.h"
#include "hil/study/campaign/campaign.h"

namespace unlatch::hil {
namespace {

// Gaussian copula: converts probabilities to normal numbers, correlates them, and converts them back to probabilities.
void correlate(const Campaign& campaign, std::vector<double>& point) {
  const std::size_t n = point.size();
  std::vector<double> normal(n);
  for (std::size_t i = 0; i < n; ++i) normal[i] = calc_normal_quantile(point[i]);
  for (std::size_t i = 0; i < n; ++i) {
    const double* const row = campaign.factor.data() + i * n;
    const bool alone = std::all_of(row, row + i, [](double x) { return x == 0; });
    if (alone) continue;  // an uncorrelated probability keeps its bits
    double z = 0;
    for (std::size_t j = 0; j <= i; ++j) z += row[j] * normal[j];
    point[i] = std::clamp(calc_normal_cdf(z), kLeastUnit, 1 - kLeastUnit);
  }
}

// Discrete value of a path: of a row the value in its column.
const YamlNode& get_choice(const CampaignParameter& parameter, std::size_t path, std::size_t index) {
  const YamlNode& choice = parameter.choices.at(index);
  return parameter.columns.empty() ? choice : choice.items.at(parameter.columns[path]);
}

}  // namespace

std::vector<InputColumn> list_inputs(const CampaignParameter& parameter) {
  if (!parameter.distribution.is_cone())
    return {{parameter.name, parameter.unit, parameter.shown, !parameter.choices.empty()}};
  std::vector<InputColumn> columns;
  for (const char* axis : {".x", ".y", ".z"}) columns.push_back({parameter.name + axis, ""});
  return columns;
}

std::vector<InputColumn> list_inputs(const Campaign& campaign) {
  std::vector<InputColumn> columns;
  for (const CampaignParameter& parameter : campaign.parameters)
    for (const InputColumn& column : list_inputs(parameter)) columns.push_back(column);
  return columns;
}

std::optional<WrittenUnit> find_shown_unit(const Campaign& campaign, const std::string& requirement) {
  const YamlNode& root = campaign.tree->get_root();
  const auto find = [&](const YamlNode* node) -> std::optional<WrittenUnit> {
    if (node == nullptr) return std::nullopt;
    if (node->is_sequence()) node = node->items.empty() ? nullptr : node->items.data();
    if (node == nullptr || !node->is_scalar()) return std::nullopt;
    if (const auto unit = find_written_unit(node->text)) return unit;
    const YamlNode* const constants = root.find("constants");
    const YamlNode* const constant = constants != nullptr ? constants->find(node->text) : nullptr;
    return constant != nullptr && constant->is_scalar() ? find_written_unit(constant->text) : std::nullopt;
  };
  const YamlNode* const list = root.find("requirements");
  if (list == nullptr || !list->is_sequence()) return std::nullopt;
  for (const YamlNode& item : list->items) {
    const YamlNode* const id = item.find("id");
    if (id == nullptr || !id->is_text(requirement)) continue;
    for (const char* key : {"at_least", "at_most", "range"})
      if (const auto unit = find(item.find(key))) return unit;
  }
  return std::nullopt;
}

std::vector<double> calc_inputs(const Campaign& campaign, const std::vector<double>& point_in) {
  std::vector<double> point = point_in, inputs;
  if (!campaign.factor.empty()) correlate(campaign, point);
  std::size_t at = 0;
  for (const CampaignParameter& parameter : campaign.parameters) {
    const Distribution& distribution = parameter.distribution;
    if (distribution.is_cone()) {
      const auto direction = tilt(parameter.direction, distribution.calc_quantile(point[at]), point[at + 1]);
      inputs.insert(inputs.end(), direction.begin(), direction.end());
    } else {
      inputs.push_back(distribution.calc_quantile(point[at]));
    }
    at += distribution.get_dimensions();
  }
  return inputs;
}

std::vector<double> draw_inputs(const Campaign& campaign, std::int64_t sample) {
  if (campaign.plan.sampling == Sampling::kCsv) return campaign.table.at(static_cast<std::size_t>(sample));
  if (campaign.failure && sample >= campaign.failure->samples)
    throw std::out_of_range("sample " + std::to_string(sample) + " follows from the results of others");
  return calc_inputs(campaign, calc_point(campaign.plan, sample));
}

std::vector<Setting> make_settings(const Campaign& campaign, const std::vector<double>& inputs) {
  std::vector<Setting> settings;
  std::size_t at = 0;
  for (const CampaignParameter& parameter : campaign.parameters) {
    const std::size_t width = parameter.distribution.is_cone() ? 3 : 1;
    for (std::size_t k = 0; k < parameter.paths.size(); ++k) {
      const std::string& path = parameter.paths[k];
      if (width == 3)
        settings.push_back(make_setting(path, std::span<const double>(inputs).subspan(at, 3)));
      else if (!parameter.choices.empty())
        settings.push_back({path, get_choice(parameter, k, static_cast<std::size_t>(inputs[at]))});
      else
        settings.push_back(make_setting(path, inputs[at], parameter.unit));
    }
    at += width;
  }
  return settings;
}

}  // namespace unlatch::hil
