// Distributions of a campaign file.
#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/scenario/base/normal.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/study/campaign/campaign_reader.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const std::string kNominal = "nominal";

}  // namespace

// Reads a number with its unit, or the word `nominal`: the value in the scenario.
double CampaignReader::read_value(YamlMap& map, const std::string& key, Reading& reading,
                                  std::optional<double> fallback) {
  const YamlNode* node = fallback ? map.find(key) : map.require(key);
  if (node == nullptr) return fallback.value_or(0);
  if (node->is_text(kNominal)) {
    if (reading.nominal == nullptr || !reading.nominal->is_scalar()) {
      mistakes_.add(node->mark, "the scenario has no number there", "write the value");
      return 0;
    }
    node = reading.nominal;
  }
  YamlNode translated = *node;
  if (reading.sheet && node->is_scalar()) {
    if (const auto root = read_root_unit(node->text)) {
      if (!reading.root_unit.empty() && reading.root_unit != root->unit)
        mistakes_.add(node->mark, "values of different kinds: " + reading.root_unit + " and " + root->unit,
                      "give all in one unit");
      reading.root_unit = root->unit;
      if (!reading.shown) reading.shown = root->shown;
      return root->value;
    }
    translated.text = replace_sheet_units(node->text);
  }
  const auto quantity = read_quantity(translated, mistakes_);
  if (!quantity) return 0;
  if (quantity->dimension.is_plain() && quantity->value != 0 && !reading.plain) reading.plain = node->mark;
  if (!reading.shown) reading.shown = find_written_unit(translated.text);
  if (!quantity->dimension.is_plain()) {
    if (reading.dimension && !(*reading.dimension == quantity->dimension))
      mistakes_.add(node->mark,
                    "values of different kinds: " + describe_dimension(*reading.dimension) + " and " +
                        describe_dimension(quantity->dimension),
                    "give all in one unit");
    reading.dimension = quantity->dimension;
  }
  return quantity->value;
}

// Reads a standard deviation. A percentage is relative to the mean.
double CampaignReader::read_sigma(YamlMap& map, double mean, Reading& reading) {
  const YamlNode* const node = map.find("sigma");
  const bool relative = node != nullptr && node->is_scalar() && !node->text.empty() && node->text.back() == '%';
  const double sigma = relative ? map.number("sigma", "") * std::abs(mean) : read_value(map, "sigma", reading);
  if (node != nullptr && !(sigma >= 0)) mistakes_.add(node->mark, "sigma is below 0", "0 or more");
  return sigma;
}

void CampaignReader::read_cut(YamlMap& map, double mean, double sigma, Distribution& to, Reading& reading) {
  if (const YamlNode* within = map.find("within")) {
    const double k = read_number(*within, "", 3, mistakes_);
    if (!(k > 0)) mistakes_.add(within->mark, "within is not beyond 0", "a number of sigmas, such as 3");
    to.low = calc_normal_cdf(-k);
    to.high = calc_normal_cdf(k);
  }
  const double least = read_value(map, "min", reading, -kInfinity), most = read_value(map, "max", reading, kInfinity);
  if (!(least < most)) mistakes_.add(map.node().mark, "min is not below max", "exchange them");
  if (!(sigma > 0)) {
    if (mean < least || mean > most)
      mistakes_.add(map.node().mark, "the mean is outside min and max", "with sigma 0 it is the value");
    return;
  }
  if (least > -kInfinity) to.cut(least, kInfinity);
  if (most < kInfinity) to.cut(-kInfinity, most);
  if (!(to.low < to.high))
    mistakes_.add(map.node().mark, "nothing of the distribution is left between min and max", "widen them");
}

void CampaignReader::read_normal(const YamlNode& node, bool logarithmic, Distribution& to, Reading& reading) {
  YamlMap map(node, logarithmic ? "lognormal" : "normal", mistakes_);
  const double mean = read_value(map, "mean", reading), sigma = read_sigma(map, mean, reading);
  to.kind = logarithmic ? Distribution::Kind::kLognormal : Distribution::Kind::kNormal;
  to.a = mean;
  to.b = sigma;
  if (logarithmic) {
    if (!(mean > 0)) return mistakes_.add(node.mark, "a lognormal value is above 0", "give a mean above 0");
    const double square = calc_log(1 + sigma / mean * (sigma / mean));
    to.a = calc_log(mean) - 0.5 * square;
    to.b = std::sqrt(square);
  }
  read_cut(map, mean, sigma, to, reading);
  map.finish();
}

void CampaignReader::read_triangular(const YamlNode& node, Distribution& to, Reading& reading) {
  YamlMap map(node, "triangular", mistakes_);
  to.kind = Distribution::Kind::kTriangular;
  to.a = read_value(map, "min", reading);
  to.c = read_value(map, "mode", reading);
  to.b = read_value(map, "max", reading);
  map.finish();
  if (!(to.a < to.b && to.a <= to.c && to.c <= to.b))
    mistakes_.add(node.mark, "min, mode and max are not in order", "min <= mode <= max, min < max");
}

void CampaignReader::read_discrete(const YamlNode& node, CampaignParameter& to, Reading& reading) {
  YamlMap map(node, "discrete", mistakes_);
  const bool of_rows = map.only_one_of({"values", "rows"}, "values") == "rows";
  const YamlNode* const values = map.find(of_rows ? "rows" : "values");
  const YamlNode* const weights = map.find("weights");
  map.finish();
  Distribution& distribution = to.distribution;
  distribution.kind = Distribution::Kind::kDiscrete;
  if (values == nullptr) return;
  if (!values->is_sequence() || values->items.empty())
    return mistakes_.add(values->mark, "no list of values", "write `values: [1, 2, 5]`");
  if (of_rows) {
    const std::size_t width = to.columns.empty() ? 0 : to.columns.back() + 1;
    if (width < 2)
      return mistakes_.add(values->mark, "rows for a single path",
                           "a list of paths with `shared: true`, a path a column");
    for (const YamlNode& row : values->items)
      if (!row.is_sequence() || row.items.size() != width)
        return mistakes_.add(row.mark, "not a row of " + hil::count(width, "value"),
                             "one for each entry of `path`, in their order");
  } else {
    to.columns.clear();
  }
  const bool numbers = !of_rows && std::all_of(values->items.begin(), values->items.end(), [&](const YamlNode& item) {
    Mistakes trial(campaign_.file, {});
    for (const auto& [name, value] : mistakes_.constants()) trial.add_constant(name, value);
    return read_quantity(item, trial).has_value();
  });
  for (std::size_t i = 0; i < values->items.size(); ++i) {
    const YamlNode& item = values->items[i];
    if (!numbers) {
      to.choices.push_back(item);
      distribution.values.push_back(static_cast<double>(i));
    } else if (const auto quantity = read_quantity(item, mistakes_)) {
      distribution.values.push_back(quantity->value);
      if (!quantity->dimension.is_plain()) reading.dimension = quantity->dimension;
      if (quantity->dimension.is_plain() && quantity->value != 0 && !reading.plain) reading.plain = item.mark;
    }
  }
  std::vector<double> w(values->items.size(), 1.0);
  if (weights != nullptr) w = read_numbers(*weights, values->items.size(), "", mistakes_);
  double sum = 0;
  for (const double x : w) {
    if (!(x >= 0)) mistakes_.add(weights->mark, "a weight below 0", "0 or more");
    sum += x;
    distribution.cumulative.push_back(sum);
  }
  if (!(sum > 0)) return mistakes_.add(node.mark, "all weights are 0", "give one above 0");
  for (double& x : distribution.cumulative) x /= sum;
}

void CampaignReader::read_empirical(const YamlNode& node, CampaignParameter& to, Reading& reading) {
  YamlMap map(node, "empirical", mistakes_);
  to.distribution.kind = Distribution::Kind::kEmpirical;
  to.distribution.values = {0};
  const YamlNode *const file = map.require("file"), *const column = map.require("column");
  map.finish();
  if (file == nullptr || column == nullptr) return;
  try {
    const NumberTable table = read_number_table(campaign_.folder, read_text(*file, mistakes_), file->mark);
    const auto at = std::find(table.names.begin(), table.names.end(), column->text);
    if (at == table.names.end())
      return mistakes_.add(column->mark, "the table has no column '" + column->text + "'",
                           suggest(column->text, table.names));
    if (table.rows.size() < 2) return mistakes_.add(file->mark, "fewer than two values", "two or more rows");
    const auto place = static_cast<std::size_t>(at - table.names.begin());
    require_numbers(table, place, column->mark);
    const Quantity unit = read_unit(table, place, column->mark);
    if (!unit.dimension.is_plain()) reading.dimension = unit.dimension;
    if (unit.dimension.is_plain() && table.units[place].empty()) reading.plain = column->mark;
    to.distribution.values.clear();
    for (const std::vector<double>& row : table.rows) to.distribution.values.push_back(row[place] * unit.value);
    std::sort(to.distribution.values.begin(), to.distribution.values.end());
  } catch (const YamlError& e) {
    mistakes_.add(e.mark, e.what(), e.mend);
  }
}

void CampaignReader::read_cone(const YamlNode& node, CampaignParameter& to, Reading& reading) {
  YamlMap map(node, "cone", mistakes_);
  Distribution& distribution = to.distribution;
  distribution.kind = map.find("sigma") != nullptr ? Distribution::Kind::kNormalCone : Distribution::Kind::kCone;
  constexpr double kHalfTurn = 3.141592653589793;
  if (distribution.kind == Distribution::Kind::kNormalCone) {
    distribution.a = map.number("sigma", "rad");
    if (const YamlNode* within = map.find("within")) {  // probability 1 − exp(−k²/2)
      const double k = read_number(*within, "", 3, mistakes_);
      distribution.high = 1 - elementary::exp(-0.5 * k * k);
      if (!(k > 0)) mistakes_.add(within->mark, "within is not beyond 0", "a number of sigmas, such as 3");
    }
    if (!(distribution.a > 0 && distribution.a < 1))
      mistakes_.add(node.mark, "this sigma is not usable", "an angle above 0, below 1 rad");
  } else {
    distribution.b = map.number("within", "rad");
    if (!(distribution.b > 0 && distribution.b <= kHalfTurn))
      mistakes_.add(node.mark, "this half angle is not usable", "above 0, at most 180 deg");
  }
  const YamlNode* about = map.find("about");
  map.finish();
  if (about == nullptr || about->is_text(kNominal)) about = reading.nominal;
  if (about == nullptr || !about->is_sequence())
    return mistakes_.add(node.mark, "the scenario has no direction there", "add `about: [1, 0, 0]`");
  const Eigen::Vector3d d = read_vector(*about, "", {1, 0, 0}, mistakes_);
  to.direction = {d.x(), d.y(), d.z()};
  if (!(d.norm() > 0)) mistakes_.add(about->mark, "a direction without length", "write [x, y, z]");
}

bool CampaignReader::read_distribution(YamlMap& map, CampaignParameter& to, Reading& reading) {
  static const std::vector<std::string> kKinds{"uniform",  "normal",    "lognormal", "triangular",
                                               "discrete", "empirical", "cone"};
  const bool any =
      std::any_of(kKinds.begin(), kKinds.end(), [&](const std::string& kind) { return map.find(kind) != nullptr; });
  if (!any && campaign_.plan.sampling == Sampling::kCsv) return false;
  const std::string kind = map.only_one_of(kKinds, "a distribution");
  if (kind.empty()) return true;
  const YamlNode& node = *map.find(kind);
  if (kind == "uniform") {
    YamlMap bounds(node, "uniform", mistakes_);
    to.distribution.a = read_value(bounds, "min", reading);
    to.distribution.b = read_value(bounds, "max", reading);
    bounds.finish();
    if (!(to.distribution.a < to.distribution.b)) mistakes_.add(node.mark, "min is not below max", "exchange them");
  }
  if (kind == "normal" || kind == "lognormal") read_normal(node, kind == "lognormal", to.distribution, reading);
  if (kind == "triangular") read_triangular(node, to.distribution, reading);
  if (kind == "discrete") read_discrete(node, to, reading);
  if (kind != "discrete") to.columns.clear();
  if (kind == "empirical") read_empirical(node, to, reading);
  if (kind == "cone") read_cone(node, to, reading);
  return true;
}

}  // namespace unlatch::hil
