#include "tools/campaign/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>

#include "hil/study/sampling/sampling.h"
#include "tools/campaign/column_statistics.h"

namespace unlatch::tools {
namespace {

// Blocks of a design in which every sample has a value.
struct Blocks {
  std::vector<std::vector<double>> values;  // [place in the block][block]
  std::vector<std::int64_t> numbers;        // of these blocks
  std::int64_t left_out = 0;                // blocks in which one is missing
};

Blocks get_blocks(const CampaignData& data, const std::vector<double>& values, std::size_t size) {
  const auto samples = static_cast<std::int64_t>(size);
  Blocks blocks;
  blocks.values.resize(size);
  const std::int64_t planned = data.manifest.at("samples").get<std::int64_t>() / samples;
  for (std::size_t i = 0; i < values.size();) {
    const std::int64_t number = data.get_sample(i) / samples;
    std::vector<double> found(size, std::numeric_limits<double>::quiet_NaN());
    for (; i < values.size() && data.get_sample(i) / samples == number; ++i)
      found[static_cast<std::size_t>(data.get_sample(i) % samples)] = values[i];
    if (std::ranges::any_of(found, [](double x) { return std::isnan(x); })) continue;
    blocks.numbers.push_back(number);
    for (std::size_t k = 0; k < size; ++k) blocks.values[k].push_back(found[k]);
  }
  blocks.left_out = planned - static_cast<std::int64_t>(blocks.numbers.size());
  return blocks;
}

// The values of each input that a grid combines with all of the others: the part of the variance over the grid of
// their means. Each is exact for the grid and is without chance; rounding is 0. NaN: a sample lacks its value.
std::vector<double> calc_grid_effects(const CampaignData& data, const std::vector<double>& values) {
  std::vector<double> effects;
  const auto n = static_cast<double>(values.size());
  const bool whole = static_cast<std::int64_t>(values.size()) == data.manifest.at("samples").get<std::int64_t>() &&
                     std::ranges::none_of(values, [](double x) { return std::isnan(x); });
  double mean = 0, total = 0, most = 0;
  for (const double value : values) {
    mean += value / n;
    most = std::max(most, std::abs(value));
  }
  const double digit = 16 * std::numeric_limits<double>::epsilon() * most, rounding = n * digit * digit;
  for (const double value : values) total += (value - mean) * (value - mean);
  for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k) {
    if (!whole || !(total > rounding)) {  // of equal values nothing is explained
      effects.push_back(whole ? 0 : std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    std::map<double, std::pair<double, double>> sums;  // by the input's value: samples, sum
    const std::vector<double> input = data.read_input(k);
    for (std::size_t row = 0; row < values.size(); ++row) {
      auto& [count, sum] = sums[input[row]];
      count += 1;
      sum += values[row] - mean;
    }
    double between = 0;
    for (const auto& [value, one] : sums) between += one.second * one.second / one.first;
    effects.push_back(between > rounding ? between / total : 0);
  }
  return effects;
}

// Least and greatest value over the levels of each parameter, the others at their medians.
Json list_swings(const CampaignData& data, const std::vector<double>& values, const Json& names) {
  const double centre = data.rows > 0 && data.get_sample(0) == 0 ? values[0] : std::nan("");
  std::int64_t first = 1;
  Json swings = Json::array();
  for (std::size_t axis = 0; axis < names.size(); ++axis) {
    const std::int64_t last = first + data.manifest.at("levels").at(axis).get<std::int64_t>();
    double low = centre, high = centre;
    std::int64_t found = 0;
    for (std::size_t row = 0; row < data.rows; ++row) {
      if (data.get_sample(row) < first || data.get_sample(row) >= last || std::isnan(values[row])) continue;
      ++found;
      low = std::min(low, values[row]);
      high = std::max(high, values[row]);
    }
    const bool whole = found == last - first && !std::isnan(centre);
    swings.push_back({{"parameter", names[axis]},
                      {"least", whole ? Json(low) : Json(nullptr)},
                      {"greatest", whole ? Json(high) : Json(nullptr)}});
    first = last;
  }
  return swings;
}

void describe_blocks(const Blocks& blocks, Json& to) {
  to["blocks"] = {{"used", blocks.numbers.size()}, {"left_out", blocks.left_out}};
}

}  // namespace

Json describe_sensitivity(const CampaignData& data, const hil::RankedVariables& inputs,
                          const std::vector<double>& values, std::size_t column) {
  Json json = {{"spearman", Json::array()}};
  for (const double rho : inputs.calc_spearman(values)) json["spearman"].push_back(to_json(rho));
  const std::string sampling = data.manifest.at("sampling");
  if (sampling == "one-at-a-time") {
    // Most samples have the median of most inputs: a correlation over them is none of the distributions.
    json["spearman"] = Json::array();
    for (std::size_t k = 0; k < data.manifest.at("inputs").size(); ++k) json["spearman"].push_back(nullptr);
  } else if (sampling == "grid") {
    for (const double index : calc_grid_effects(data, values)) json["grid_effects"].push_back(to_json(index));
  } else if (sampling != "morris" && sampling != "saltelli") {
    const hil::FirstOrders orders =
        inputs.calc_first_orders(values, sampling == "sobol" ? hil::Evenness::kEven : hil::Evenness::kRandom);
    for (const hil::FirstOrder& one : orders.of_inputs)
      json["first_order"].push_back(
          {{"index", to_json(one.index)}, {"interval", {to_json(one.interval.low), to_json(one.interval.high)}}});
    json["significant"] = to_json(orders.significant);
    json["bins"] = orders.bins;
  }
  std::size_t axes = 0;
  Json names = Json::array();
  for (const Json& parameter : data.manifest.at("parameters")) {
    for (std::size_t k = 0; k < parameter.at("axes").get<std::size_t>(); ++k)
      names.push_back(parameter.at("name").get<std::string>() + (parameter.at("axes") == 1 ? ""
                                                                 : k == 0                  ? ".angle"
                                                                                           : ".turn"));
    axes += parameter.at("axes").get<std::size_t>();
  }
  const std::uint64_t seed = data.manifest.at("seed");
  if (sampling == "morris") {
    const Blocks blocks = get_blocks(data, values, axes + 1);
    describe_blocks(blocks, json);
    if (blocks.numbers.empty()) return json;
    const hil::SamplingPlan plan{hil::Sampling::kMorris, seed, data.manifest.at("samples"), axes, {}};
    std::vector<std::vector<double>> effects(axes);
    for (std::size_t i = 0; i < blocks.numbers.size(); ++i)
      for (std::size_t k = 1; k <= axes; ++k) {
        const hil::MorrisStep step = hil::get_morris_step(plan, blocks.numbers[i], k);
        effects[step.axis].push_back(step.sign * (blocks.values[k][i] - blocks.values[k - 1][i]) / hil::kMorrisStep);
      }
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const hil::MorrisEffect effect = hil::calc_morris(effects[axis]);
      json["morris"].push_back({{"parameter", names[axis]},
                                {"mean_size", effect.mean_size},
                                {"mean", effect.mean},
                                {"deviation", effect.deviation}});
    }
  }
  if (sampling == "one-at-a-time") json["swings"] = list_swings(data, values, names);
  if (sampling == "saltelli") {
    const Blocks blocks = get_blocks(data, data.read_results(column), axes + 2);
    describe_blocks(blocks, json);
    if (blocks.numbers.empty()) return json;
    const std::vector<hil::SobolIndex> indices =
        hil::calc_sobol_indices(blocks.values[0], blocks.values[1], std::span(blocks.values).subspan(2), seed);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const hil::SobolIndex& index = indices[axis];
      json["sobol"].push_back({{"parameter", names[axis]},
                               {"first", to_json(index.first)},
                               {"first_interval", to_json(index.first_interval)},
                               {"total", to_json(index.total)},
                               {"total_interval", to_json(index.total_interval)}});
    }
  }
  return json;
}

}  // namespace unlatch::tools
