// Keys `outputs` and `curves` of a campaign: outputs of the scenario that are results of every sample.
#include <algorithm>
#include <cmath>
#include <set>

#include "hil/run/analysis/run_analysis.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/study/campaign/campaign_reader.h"

namespace unlatch::hil {
namespace {

// Guess for a name that is none of these outputs, nor a column of one.
std::string correct_output(const std::string& name, const std::vector<Output>& outputs) {
  std::vector<std::string> columns;
  for (const Output& output : outputs)
    for (const Output::Column& column : output.columns) columns.push_back(column.name);
  constexpr std::size_t kTypingErrors = 2;
  const std::string* const nearest = find_nearest(name, columns, kTypingErrors);
  return nearest == nullptr ? find_fault(name, outputs)
                            : "did you mean '" + *nearest + "'? `unlatch check --outputs` lists all names";
}

}  // namespace

// Columns of the outputs that `node` names: a name or a list of them; each is an output, a pattern, or one column.
std::vector<Output::Column> CampaignReader::read_output_names(const YamlNode& node,
                                                              const std::vector<Output>& outputs) {
  std::vector<Output::Column> chosen;
  std::vector<const YamlNode*> names;
  if (node.is_sequence())
    for (const YamlNode& item : node.items) names.push_back(&item);
  else
    names.push_back(&node);
  if (names.empty()) mistakes_.add(node.mark, "no outputs are named", "write `of: core.position`");
  for (const YamlNode* name : names) {
    const std::size_t before = chosen.size();
    const std::string text = read_text(*name, mistakes_);
    for (const Output& output : outputs)
      for (const Output::Column& column : output.columns)
        if (column.name == text || matches(text, output)) chosen.push_back(column);
    if (chosen.size() == before && name->is_scalar())
      mistakes_.add(name->mark, "the scenario has no output '" + text + "'", correct_output(text, outputs));
  }
  for (Output::Column& column : chosen)
    if (column.unit == "1") column.unit.clear();
  return chosen;
}

void CampaignReader::read_outputs(YamlMap& top) {
  const YamlNode *const values = top.find("outputs"), *const curves = top.find("curves");
  if (values == nullptr && curves == nullptr) return;
  const std::vector<Output> outputs = list_outputs(campaign_.tree->get_nominal());
  const auto read_list = [&](const YamlNode* node, const char* key, const char* right, auto&& read_one) {
    if (node == nullptr) return;
    if (!node->is_sequence() || node->items.empty())
      return mistakes_.add(node->mark, std::string(key) + " is not a list", right);
    for (const YamlNode& item : node->items) read_one(item);
  };
  read_list(values, "outputs", "write `- {of: core.velocity, take: final}`",
            [&](const YamlNode& item) { read_chosen_value(item, outputs); });
  read_list(curves, "curves", "write `- {of: core.velocity, every: 50 ms}`",
            [&](const YamlNode& item) { read_curves(item, outputs); });
  if (const std::size_t count = campaign_.chosen.count(); count > kMostChosen)
    mistakes_.add((curves != nullptr ? curves : values)->mark,
                  "outputs and curves make " + hil::count(count, "column") + "; at most " +
                      std::to_string(kMostChosen) + " fit into a table",
                  "fewer names, or a longer `every`");
}

void CampaignReader::read_chosen_value(const YamlNode& node, const std::vector<Output>& outputs) {
  YamlMap map(node, "an output", mistakes_);
  const YamlNode* const of = map.require("of");
  const int take = map.choice("take", "way to take an output", kTakeNames, 0);
  map.finish();
  if (of == nullptr || take < 0) return;
  for (const Output::Column& column : read_output_names(*of, outputs)) {
    const auto same = [&](const ChosenOutput& other) {
      return other.name == column.name && other.take == static_cast<ChosenOutput::Take>(take);
    };
    if (std::ranges::any_of(campaign_.chosen.values, same))
      mistakes_.add(of->mark, "'" + column.name + "' is chosen twice", "leave one of them out");
    else
      campaign_.chosen.values.push_back({column.name, column.unit, static_cast<ChosenOutput::Take>(take)});
  }
}

void CampaignReader::read_curves(const YamlNode& node, const std::vector<Output>& outputs) {
  YamlMap map(node, "curves", mistakes_);
  const YamlNode *const of = map.require("of"), *const every = map.require("every");
  ChosenCurves group;
  const Scenario& scenario = campaign_.tree->get_nominal();
  if (every != nullptr) {
    constexpr double kWhole = 1e-9, kMostSteps = 1e15;  // relative
    const std::size_t before = mistakes_.count();
    group.every = read_number(*every, "s", scenario.dt, mistakes_);
    const double steps = group.every / scenario.dt, nearest = std::round(steps);
    const double points = std::floor(scenario.until / group.every * (1 + kWhole)) + 1;
    if (mistakes_.count() > before) {
      // reported already
    } else if (!(nearest >= 1 && steps <= kMostSteps && std::abs(steps - nearest) <= kWhole * nearest)) {
      const double whole = std::clamp(nearest, 1.0, kMostSteps);
      mistakes_.add(every->mark, "this time is not a whole number of steps of " + to_text(scenario.dt) + " s",
                    "such as " + to_text(whole * scenario.dt) + " s");
    } else if (group.every > scenario.until * (1 + kWhole)) {
      mistakes_.add(every->mark, "the run is shorter: it ends at " + to_text(scenario.until) + " s",
                    "a shorter time; the value at the end is one of `outputs`");
    } else {
      group.points = static_cast<std::size_t>(std::min(points, static_cast<double>(kMostChosen) + 1));
    }
  }
  map.finish();
  if (of == nullptr) return;
  for (Output::Column& column : read_output_names(*of, outputs)) {
    const auto has = [&](const ChosenCurves& other) {
      return std::ranges::any_of(other.curves, [&](const auto& curve) { return curve.name == column.name; });
    };
    if (has(group) || std::ranges::any_of(campaign_.chosen.curves, has))
      mistakes_.add(of->mark, "'" + column.name + "' has two curves", "leave one of them out");
    else
      group.curves.push_back({std::move(column.name), std::move(column.unit)});
  }
  campaign_.chosen.curves.push_back(std::move(group));
}

}  // namespace unlatch::hil
