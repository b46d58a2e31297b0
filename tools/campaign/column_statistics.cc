#include "tools/campaign/column_statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hil/scenario/yaml/setting.h"

namespace unlatch::tools {
namespace {

constexpr double kProbabilities[] = {0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999};

}  // namespace

Json to_json(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json to_json(const hil::Interval& interval) { return Json::array({interval.low, interval.high}); }

Json to_json(const std::optional<hil::Interval>& interval) { return interval ? to_json(*interval) : Json(nullptr); }

std::vector<double> sort_present(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  std::sort(values.begin(), values.end());
  return values;
}

void add_quantiles(const std::vector<double>& sorted, Json& to) {
  to["quantiles"] = Json::object();
  to["intervals"] = Json::object();
  for (const double p : kProbabilities) {
    to["quantiles"][hil::to_text(p)] = to_json(hil::calc_quantile(sorted, p));
    if (const auto interval = hil::calc_quantile_interval(sorted, p))
      to["intervals"][hil::to_text(p)] = to_json(*interval);
  }
}

void add_no_quantiles(Json& to) {
  to["quantiles"] = Json::object();
  for (const double p : kProbabilities) to["quantiles"][hil::to_text(p)] = nullptr;
  to["intervals"] = Json::object();
}

Json describe_column(const Json& column, const std::vector<double>& values, bool drawn) {
  const std::vector<double> sorted = sort_present(values);
  Json json = {{"name", column.at("name")},
               {"unit", column.at("unit")},
               {"count", sorted.size()},
               {"missing", values.size() - sorted.size()}};
  double mean = 0, square = 0;
  for (const double x : sorted) mean += x / static_cast<double>(sorted.size());
  for (const double x : sorted) square += (x - mean) * (x - mean);
  if (column.contains("shown")) json["shown"] = column.at("shown");
  json["mean"] = sorted.empty() ? Json(nullptr) : to_json(mean);
  json["deviation"] =
      sorted.size() < 2 ? Json(nullptr) : to_json(std::sqrt(square / static_cast<double>(sorted.size() - 1)));
  json["min"] = sorted.empty() ? Json(nullptr) : to_json(sorted.front());
  json["max"] = sorted.empty() ? Json(nullptr) : to_json(sorted.back());
  if (drawn)
    add_quantiles(sorted, json);
  else
    add_no_quantiles(json);
  return json;
}

Json describe_curve(const CampaignData& data, const Json& curve, bool drawn) {
  Json json = {{"name", curve.at("name")}, {"unit", curve.at("unit")}, {"times", curve.at("times")}};
  for (const char* key : {"count", "min", "0.05", "0.5", "0.95", "max"}) json[key] = Json::array();
  const auto first = curve.at("first_column").get<std::size_t>();
  for (std::size_t point = 0; point < curve.at("times").size(); ++point) {
    const std::vector<double> sorted = sort_present(data.read_results(first + point));
    json["count"].push_back(sorted.size());
    for (const auto& [key, p] : {std::pair{"min", 0.0}, {"0.05", 0.05}, {"0.5", 0.5}, {"0.95", 0.95}, {"max", 1.0}})
      json[key].push_back(drawn || p == 0 || p == 1 ? to_json(hil::calc_quantile(sorted, p)) : Json(nullptr));
  }
  return json;
}

}  // namespace unlatch::tools
