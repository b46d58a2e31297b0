#include "hil/study/campaign/campaign.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/yaml/yaml_override.h"
#include "hil/study/campaign/campaign_reader.h"

namespace unlatch::hil {
namespace {

namespace fs = std::filesystem;

constexpr double kMostSamples = 1e9, kMostSeed = 9007199254740992.0;  // 2^53: exact in every reader of numbers
constexpr std::size_t kMostDraws = 500;

const std::string kNoUnit;

}  // namespace

bool is_campaign(const std::string& text) {
  try {
    return parse_yaml(text).find("unlatch_campaign") != nullptr;
  } catch (const YamlError&) {
    return text.starts_with("unlatch_campaign") || text.find("\nunlatch_campaign") != std::string::npos;
  }
}

Campaign load_campaign(const std::string& path, const std::vector<std::string>& overrides) {
  const std::string folder = is_standard_input(path) ? "" : fs::path(path).parent_path().string();
  return load_campaign_text(read_text_file(path, "campaign"), path == "-" ? "<stdin>" : path,
                            folder.empty() ? "." : folder, overrides);
}

Campaign load_campaign_text(const std::string& text, const std::string& file, const std::string& folder,
                            const std::vector<std::string>& overrides) {
  Campaign campaign;
  campaign.file = file;
  campaign.text = text;
  campaign.folder = folder;
  Mistakes mistakes(file, {});
  YamlNode root;
  try {
    root = parse_yaml(text);
  } catch (const YamlError& e) {
    mistakes.add(e.mark, e.what(), e.mend);
    mistakes.throw_if_any();
  }
  CampaignReader(campaign, mistakes).read(root, overrides);
  mistakes.throw_if_any();
  check_draws(campaign, mistakes);
  mistakes.throw_if_any();
  return campaign;
}

void CampaignReader::read(const YamlNode& root, const std::vector<std::string>& overrides) {
  YamlMap top(root, "the campaign", mistakes_);
  if (!root.is_mapping()) return;
  top.read_header("unlatch_campaign");
  if (const YamlNode* name = top.require("name")) campaign_.name = read_name(*name, mistakes_);
  if (const YamlNode* title = top.find("title")) campaign_.title = read_text(*title, mistakes_);
  read_scenario(top, overrides);
  read_plan(top);
  if (campaign_.tree) {
    read_constants();
    read_parameters(top);
    read_correlations(top);
    finish_plan(top);
    read_tolerance(top);
    read_outputs(top);
    refuse_names_of_results();
    read_subset(top);
    read_table(top);
    const Sampling sampling = campaign_.plan.sampling;
    if (get_basis(sampling) == SampleBasis::kChosen && !campaign_.tree->get_nominal().requirements.empty())
      campaign_.remarks.push_back(describe_basis(sampling));
  } else {
    for (const char* unread : {"parameters", "correlations", "table", "subset", "outputs", "curves", "tolerance"})
      top.find(unread);
  }
  top.finish();
}

void CampaignReader::read_scenario(YamlMap& top, const std::vector<std::string>& overrides) {
  const YamlNode* const node = top.require("scenario");
  std::vector<std::string> all;
  if (const YamlNode* set = top.find("set")) {
    if (!set->is_mapping()) mistakes_.add(set->mark, "set is not a mapping", "write `bodies.core.mass: 98 t`");
    for (std::size_t i = 0; i < set->keys.size(); ++i)
      all.push_back(to_text(Setting{set->keys[i].text, set->items[i]}));
  }
  all.insert(all.end(), overrides.begin(), overrides.end());
  if (node == nullptr) return;
  const std::string name = read_text(*node, mistakes_);
  if (name.empty()) return mistakes_.add(node->mark, "no scenario is named", "write a path from this file");
  campaign_.scenario = fs::path(name).is_absolute() ? name : (fs::path(campaign_.folder) / name).string();
  overrides_ = all;
  try {
    campaign_.tree = std::make_shared<ScenarioTree>(campaign_.scenario, all);
    const std::string absent = describe_absence(campaign_.tree->get_nominal().flight_software, "a campaign");
    if (!absent.empty()) campaign_.remarks.push_back(absent);
  } catch (const ScenarioError& error) {
    for (const ScenarioMistake& mistake : error.mistakes)
      mistakes_.add(node->mark, "its scenario: " + mistake.to_string(), "");
  }
}

// Reads the constants of the scenario, for expressions.
void CampaignReader::read_constants() {
  const YamlNode* const constants = campaign_.tree->get_root().find("constants");
  if (constants == nullptr) return;
  for (std::size_t i = 0; i < constants->keys.size(); ++i)
    if (const auto value = read_quantity(constants->items[i], mistakes_))
      mistakes_.add_constant(constants->keys[i].text, *value);
}

// Dimension of the number at the path: that of a constant, or of what the scenario's reader took it for.
std::optional<Dimension> CampaignReader::find_dimension(const std::string& path) {
  for (const NamedConstant& constant : campaign_.tree->get_nominal().constants)
    if (path == "constants." + constant.name) return constant.value.dimension;
  if (!numbers_) numbers_ = load_scenario(campaign_.scenario, overrides_).numbers;
  for (const WrittenNumber& number : *numbers_)
    if (number.path == path) return dimension_of(number.unit);
  return std::nullopt;
}

void CampaignReader::read_plan(YamlMap& top) {
  SamplingPlan& plan = campaign_.plan;
  const int sampling = top.choice("sampling", "sampling", kSamplingNames, 0);
  if (sampling >= 0) plan.sampling = static_cast<Sampling>(sampling);
  plan.samples = static_cast<std::int64_t>(read_whole(top, "samples", 0, 0, kMostSamples));
  plan.seed = static_cast<std::uint64_t>(read_whole(top, "seed", 1, 0, kMostSeed));
  levels_ = read_levels(top, 3);
}

void CampaignReader::read_tolerance(YamlMap& top) {
  campaign_.tolerance = read_bounded(top, get_number_key("campaign.campaign.tolerance"), 0.0, mistakes_);
  if (!(campaign_.tolerance > 0)) return;
  campaign_.chosen.steps = true;
  for (const CampaignParameter& parameter : campaign_.parameters)
    for (const std::string& path : parameter.paths)
      if (path == "step.dt")
        mistakes_.add(parameter.mark, "the step varies, and the campaign has a tolerance, which chooses it",
                      "leave one of them out");
}

double CampaignReader::read_whole(YamlMap& map, const char* key, double fallback, double least, double most) {
  const double value = map.number(key, kNoUnit, fallback);
  if (value >= least && value <= most && value == std::floor(value)) return value;
  mistakes_.add(map.node().find(key)->mark, std::string("this number of ") + key + " is not usable",
                "a whole number from " + to_text(least) + " to " + to_text(most));
  return fallback;
}

int CampaignReader::read_levels(YamlMap& map, int fallback) {
  constexpr double kLeastLevels = 2, kMostLevels = 10000;
  return static_cast<int>(read_whole(map, "levels", fallback, kLeastLevels, kMostLevels));
}

void CampaignReader::read_parameters(YamlMap& top) {
  const YamlNode* const node = top.require("parameters");
  if (node == nullptr) return;
  YamlMap map(*node, "parameters", mistakes_);
  for (std::size_t i = 0; i < node->keys.size(); ++i) {
    const YamlKey& key = node->keys[i];
    if (node->find(key.text) != &node->items[i]) continue;  // duplicate: finish() reports it
    map.find(key.text);
    if (!is_name(key.text))
      mistakes_.add(key.mark, "'" + key.text + "' cannot be the name of a parameter", describe_name_rule(key.text));
    read_parameter(key.text, node->items[i]);
  }
  map.finish();
  std::set<std::string> taken;
  for (const CampaignParameter& parameter : campaign_.parameters)
    for (const std::string& path : parameter.paths)
      if (!taken.insert(path).second)
        mistakes_.add(parameter.mark, "'" + path + "' is varied twice", "leave one of the parameters out");
  if (node->is_mapping() && node->keys.empty())
    mistakes_.add(node->mark, "nothing varies",
                  "add `NAME: {path: bodies.core.mass, normal: {mean: nominal, sigma: 1 %}}`");
}

// Refuses parameters whose column of the table, or of the statistics, could not be told from that of a result.
void CampaignReader::refuse_names_of_results() {
  std::set<std::string> results;
  for (const ResultColumn& column : list_columns(campaign_.tree->get_nominal(), campaign_.chosen))
    results.insert(column.name);
  std::set<std::string> told;
  for (const CampaignParameter& parameter : campaign_.parameters)
    for (const InputColumn& input : list_inputs(parameter))
      if (results.contains(input.name) && told.insert(parameter.name).second)
        mistakes_.add(parameter.mark,
                      "'" + input.name +
                          "' is a result of the scenario, such as a requirement, too: the table would "
                          "have two columns of this name",
                      "give the parameter another name");
}

namespace {

// True if no two are equal.
bool are_different(const std::vector<std::string>& names) {
  return std::set<std::string>(names.begin(), names.end()).size() == names.size();
}

// Names of the places that one parameter varies independently: what their stars stand for; if two paths make these
// equal, as elements.low_*.preload and elements.high_*.preload do, the part of the path with the star ("low_l");
// at last, their numbers from 1.
std::vector<std::string> name_places(const std::vector<MetPath>& paths) {
  std::vector<std::string> stars, parts, numbers;
  for (const MetPath& met : paths) {
    numbers.push_back(std::to_string(numbers.size() + 1));
    stars.push_back(met.stars.empty() ? numbers.back() : met.stars);
    parts.push_back(met.parts.empty() ? numbers.back() : met.parts);
  }
  for (const std::vector<std::string>* names : {&stars, &parts})
    if (are_different(*names)) return *names;
  return numbers;
}

}  // namespace

// A plain number for a constant that the file gives in millimetres would be one of metres.
void CampaignReader::refuse_plain_numbers(const CampaignParameter& parameter, const Reading& reading) {
  const YamlNode& root = campaign_.tree->get_root();
  for (std::size_t k = 0; k < parameter.paths.size(); ++k) {
    const std::string& path = parameter.paths[k];
    const std::optional<WrittenUnit> unit = find_constant_unit(root, path);
    if (!unit) continue;
    std::optional<SourceMark> plain = parameter.choices.empty() ? reading.plain : std::nullopt;
    for (const YamlNode& choice : parameter.choices) {
      const YamlNode& own = parameter.columns.empty() ? choice : choice.items.at(parameter.columns[k]);
      Mistakes ignored(campaign_.file, {});
      for (const auto& [name, value] : mistakes_.constants()) ignored.add_constant(name, value);
      const auto number = own.is_scalar() ? read_quantity(own, ignored) : std::nullopt;
      if (number && number->dimension.is_plain() && number->value != 0 && !plain) plain = own.mark;
    }
    if (plain)
      mistakes_.add(
          *plain, "a plain number for '" + path + "', which the scenario gives in " + unit->name,
          "write the unit: 1 " + unit->name + ", or that of SI; in a table as its column's, [" + unit->name + "]");
  }
}

void CampaignReader::read_parameter(const std::string& name, const YamlNode& node) {
  const std::size_t before = mistakes_.count();
  YamlMap map(node, "a parameter", mistakes_);
  CampaignParameter parameter;
  parameter.name = name;
  parameter.mark = node.mark;
  const bool shared = map.boolean("shared", false);
  std::vector<MetPath> paths;
  std::vector<std::size_t> columns;  // entry of the list that made each
  if (const YamlNode* path = map.require("path")) {
    std::vector<const YamlNode*> list;
    if (path->is_sequence())
      for (const YamlNode& item : path->items) list.push_back(&item);
    else
      list.push_back(path);
    for (std::size_t k = 0; k < list.size(); ++k) try {
        const YamlNode* const item = list[k];
        const std::string text = read_text(*item, mistakes_);
        if (item->is_scalar())
          for (MetPath& met : expand_path(text, item->mark, campaign_.tree->get_root())) {
            paths.push_back(std::move(met));
            columns.push_back(k);
          }
      } catch (const YamlError& e) {
        mistakes_.add(e.mark, e.what(), e.mend);
      }
  }
  std::vector<std::size_t> made;
  const auto add = [&](CampaignParameter one, const std::string& first_path) {
    Reading reading;
    try {
      reading.nominal = find_value(first_path, node.mark, campaign_.tree->get_root());
    } catch (const YamlError& e) {
      mistakes_.add(e.mark, e.what(), e.mend);
      return;
    }
    reading.sheet = first_path.starts_with("sensors.") && first_path.find(".errors.") != std::string::npos;
    one.drawn = read_distribution(map, one, reading);
    const bool by_index = !one.choices.empty();
    refuse_plain_numbers(one, reading);
    if (!reading.dimension && !by_index) reading.dimension = find_dimension(first_path);
    if (reading.dimension && !by_index) one.unit = describe_unit(*reading.dimension);
    if (!reading.root_unit.empty()) one.unit = reading.root_unit;
    if (!one.unit.empty() && reading.shown) one.shown = reading.shown;
    one.levels = read_levels(map, levels_);
    if (one.distribution.kind == Distribution::Kind::kDiscrete)
      one.levels = static_cast<int>(one.distribution.values.size());
    made.push_back(campaign_.parameters.size());
    campaign_.parameters.push_back(std::move(one));
  };
  if (shared || paths.size() == 1) {
    for (const MetPath& met : paths) parameter.paths.push_back(met.path);
    if (shared) parameter.columns = columns;
    if (!paths.empty()) add(parameter, paths[0].path);
  } else {
    const std::vector<std::string> places = name_places(paths);
    for (std::size_t i = 0; i < paths.size() && mistakes_.count() == before; ++i) {  // stops after the first mistake
      CampaignParameter one = parameter;
      one.name += ":" + places[i];
      one.paths = {paths[i].path};
      add(std::move(one), paths[i].path);
    }
  }
  if (campaign_.parameters.size() > kMostDraws) mistakes_.add(node.mark, "more than 500 parameters", "share some");
  groups_.emplace_back(name, made);
  map.finish();
}

void CampaignReader::read_correlations(YamlMap& top) {
  const YamlNode* const node = top.find("correlations");
  if (node == nullptr) return;
  if (!node->is_sequence())
    return mistakes_.add(node->mark, "correlations is not a list", "write `- {between: [a, b], rho: 0.5}`");
  const auto find = [&](const YamlNode& name) -> std::vector<std::size_t> {
    for (const auto& [group, members] : groups_)
      if (group == name.text) return members;
    std::vector<std::string> known;
    for (std::size_t i = 0; i < campaign_.parameters.size(); ++i) {
      if (campaign_.parameters[i].name == name.text) return {i};
      known.push_back(campaign_.parameters[i].name);
    }
    mistakes_.add(name.mark, "no parameter '" + name.text + "'", suggest(name.text, known));
    return {};
  };
  for (const YamlNode& item : node->items) {
    YamlMap map(item, "a correlation", mistakes_);
    const YamlNode* const between = map.require("between");
    const double rho = map.number("rho", kNoUnit);
    map.finish();
    if (!(rho > -1 && rho < 1)) mistakes_.add(item.mark, "this correlation is not usable", "more than -1, less than 1");
    if (between == nullptr) continue;
    if (!between->is_sequence() || between->items.size() != 2) {
      mistakes_.add(between->mark, "a correlation is between two parameters", "write `between: [a, b]`");
      continue;
    }
    const std::vector<std::size_t> a = find(between->items[0]), b = find(between->items[1]);
    if (a.size() != b.size() && !a.empty() && !b.empty())
      mistakes_.add(between->mark, "these make " + std::to_string(a.size()) + " and " + hil::count(b.size(), "draw"),
                    "name single ones: mass:1");
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
      if (a[i] == b[i]) mistakes_.add(between->mark, "a parameter with itself", "name two");
      for (const std::size_t k : {a[i], b[i]})
        if (campaign_.parameters[k].distribution.is_cone())
          mistakes_.add(between->mark, "a direction cannot be correlated", "leave it out");
      const auto same = [&](const Correlation& other) {
        return (other.a == a[i] && other.b == b[i]) || (other.a == b[i] && other.b == a[i]);
      };
      if (std::ranges::any_of(campaign_.correlations, same))
        mistakes_.add(between->mark,
                      "the correlation of '" + campaign_.parameters[a[i]].name + "' and '" +
                          campaign_.parameters[b[i]].name + "' is given twice",
                      "leave one of the two out");
      campaign_.correlations.push_back({a[i], b[i], rho});
    }
  }
  const Sampling s = campaign_.plan.sampling;
  if (s != Sampling::kRandom && s != Sampling::kLatinHypercube && s != Sampling::kSobol && s != Sampling::kSubset)
    mistakes_.add(node->mark,
                  "correlations have no meaning with sampling " + kSamplingNames[static_cast<std::size_t>(s)],
                  "leave them out, or write `sampling: random`");
}

// Sets the number of samples, the levels, and the factor of the correlations.
void CampaignReader::finish_plan(YamlMap& top) {
  SamplingPlan& plan = campaign_.plan;
  std::vector<std::size_t> first;  // first dimension of each parameter
  for (const CampaignParameter& parameter : campaign_.parameters) {
    first.push_back(plan.dimensions);
    plan.dimensions += parameter.distribution.get_dimensions();
    for (std::size_t k = 0; k < parameter.distribution.get_dimensions(); ++k) plan.levels.push_back(parameter.levels);
  }
  const YamlNode* const samples = top.node().find("samples");
  const SourceMark mark = samples != nullptr ? samples->mark : top.node().mark;
  const std::int64_t made = count_samples(plan), block = get_block(plan);
  if (made > static_cast<std::int64_t>(kMostSamples))
    mistakes_.add(mark, "this grid has more than 1e9 samples", "fewer levels, or another sampling");
  if (made > 0 && samples != nullptr && plan.samples != made)
    mistakes_.add(mark, "this sampling makes " + hil::count(made, "sample"), "write that, or leave samples out");
  if (made > 0) plan.samples = made;
  if (plan.sampling != Sampling::kCsv && plan.samples == 0)
    mistakes_.add(mark, "the campaign has no samples", "add `samples: 1000`");
  else if (plan.samples % block != 0)
    mistakes_.add(mark, "this sampling takes " + hil::count(block, "sample") + " a block",
                  "write a multiple: " + std::to_string((plan.samples / block + 1) * block));
  const auto count = static_cast<std::uint64_t>(plan.samples);
  if (plan.sampling == Sampling::kSobol && count > 0 && !std::has_single_bit(count))
    campaign_.remarks.push_back(
        "sobol spreads samples evenly where their number is a power of two: " + std::to_string(std::bit_floor(count)) +
        " or " + std::to_string(std::bit_ceil(count)) + ", not " + std::to_string(count));
  if (campaign_.correlations.empty()) return;
  const std::size_t n = plan.dimensions;
  std::vector<double>& l = campaign_.factor;
  l.assign(n * n, 0);
  for (std::size_t i = 0; i < n; ++i) l[i * n + i] = 1;
  for (const Correlation& pair : campaign_.correlations) {
    const std::size_t a = first[pair.a], b = first[pair.b];
    l[std::max(a, b) * n + std::min(a, b)] = pair.rho;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = l[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= l[i * n + k] * l[j * n + k];
      if (i == j && !(sum > 0))
        return mistakes_.add(top.node().find("correlations")->mark, "these correlations contradict each other",
                             "the matrix of all of them is not positive definite: make some smaller");
      l[i * n + j] = i == j ? std::sqrt(sum) : sum / l[j * n + j];
    }
  }
}

namespace {

// Columns of a table that no parameter reads: a parameter may have been forgotten.
std::string describe_unread(const std::vector<std::string>& columns) {
  std::string text = "the table has " + hil::count(columns.size(), "column") + " that no parameter reads:";
  for (std::size_t i = 0; i < columns.size(); ++i) text += (i == 0 ? " '" : ", '") + columns[i] + "'";
  return text;
}

}  // namespace

void CampaignReader::read_table(YamlMap& top) {
  const bool from_table = campaign_.plan.sampling == Sampling::kCsv;
  const YamlNode* const node = from_table ? top.require("table") : top.find("table");
  if (node == nullptr) return;
  if (!from_table)
    return mistakes_.add(node->mark, "a table without `sampling: csv`", "add that, or leave the table out");
  try {
    const NumberTable table = read_number_table(campaign_.folder, read_text(*node, mistakes_), node->mark);
    std::vector<std::size_t> places;
    std::vector<double> factors;
    for (const InputColumn& input : list_inputs(campaign_)) {
      const auto at = std::find(table.names.begin(), table.names.end(), input.name);
      if (at == table.names.end())
        mistakes_.add(node->mark, "the table has no column '" + input.name + "'", suggest(input.name, table.names));
      places.push_back(static_cast<std::size_t>(at - table.names.begin()));
      factors.push_back(at == table.names.end() ? 1 : read_factor(table, places.back(), input.unit, node->mark));
    }
    if (places.end() != std::find(places.begin(), places.end(), table.names.size())) return;
    for (const std::size_t place : places) require_numbers(table, place, node->mark);
    for (const CampaignParameter& parameter : campaign_.parameters) {
      const auto at = std::find(table.names.begin(), table.names.end(), parameter.name);
      if (at == table.names.end() || !table.units[static_cast<std::size_t>(at - table.names.begin())].empty()) continue;
      Reading reading;
      reading.plain = parameter.mark;
      refuse_plain_numbers(parameter, reading);
    }
    std::vector<std::string> unread;
    for (std::size_t i = 0; i < table.names.size(); ++i)
      if (std::ranges::find(places, i) == places.end()) unread.push_back(table.names[i]);
    if (!unread.empty()) campaign_.remarks.push_back(describe_unread(unread));
    for (const std::vector<double>& row : table.rows) {
      std::vector<double>& inputs = campaign_.table.emplace_back();
      for (std::size_t i = 0; i < places.size(); ++i) inputs.push_back(row[places[i]] * factors[i]);
    }
    if (top.node().find("samples") == nullptr) campaign_.plan.samples = static_cast<std::int64_t>(table.rows.size());
    if (campaign_.plan.samples > static_cast<std::int64_t>(table.rows.size()) || table.rows.empty())
      mistakes_.add(node->mark, "the table has " + hil::count(table.rows.size(), "row"), "a row for each sample");
  } catch (const YamlError& e) {
    mistakes_.add(e.mark, e.what(), e.mend);
  }
}

}  // namespace unlatch::hil
