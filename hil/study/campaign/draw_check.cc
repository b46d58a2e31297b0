// Check that the values which a campaign may draw make valid scenarios: tried at the ends of each parameter, at every
// discrete value, and at corners and draws of all.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "hil/run/findings/findings.h"
#include "hil/run/run.h"
#include "hil/scenario/base/philox.h"
#include "hil/study/campaign/campaign_findings.h"
#include "hil/study/campaign/campaign_reader.h"

namespace unlatch::hil {
namespace {

// Returns the first mistake of the scenario with these settings; "" if it is valid.
std::string find_mistake(const Campaign& campaign, const std::vector<Setting>& settings) {
  try {
    (void)campaign.tree->read(settings);
    return "";
  } catch (const ScenarioError& error) {
    return error.mistakes.at(0).what;
  }
}

std::string find_mistake_at(const Campaign& campaign, const std::vector<double>& point) {
  return find_mistake(campaign, make_settings(campaign, calc_inputs(campaign, point)));
}

// Checks the median of each parameter alone, in the unit that the file gives it.
bool check_medians(const Campaign& campaign, const std::vector<double>& median, Mistakes& mistakes) {
  const std::vector<InputColumn> columns = list_inputs(campaign);
  const std::vector<double> inputs = calc_inputs(campaign, median);
  bool sound = true;
  std::size_t at = 0;
  for (const CampaignParameter& parameter : campaign.parameters) {
    std::vector<Setting> settings = make_settings(campaign, inputs);
    std::erase_if(settings, [&](const Setting& setting) {
      return std::find(parameter.paths.begin(), parameter.paths.end(), setting.path) == parameter.paths.end();
    });
    if (const std::string mistake = find_mistake(campaign, settings); !mistake.empty()) {
      mistakes.add(parameter.mark,
                   "parameter '" + parameter.name + "' at its median, " + to_text(inputs[at]) + ": " + mistake,
                   "every value that may be drawn must make a valid scenario");
      sound = false;
    }
    at += parameter.distribution.is_cone() ? 3 : 1;
  }
  return sound;
}

// Returns the probability of values beyond the one at which the scenario becomes invalid.
double find_probability(const Campaign& campaign, std::vector<double> point, std::size_t axis, bool upper) {
  double valid = 0.5, wrong = upper ? 1 - kLeastUnit : kLeastUnit;
  constexpr int kHalvings = 30;
  for (int i = 0; i < kHalvings; ++i) {  // by the ratio of the tails, so that small probabilities are found
    const double tail = std::sqrt(upper ? (1 - valid) * (1 - wrong) : valid * wrong);
    point[axis] = upper ? 1 - tail : tail;
    (find_mistake_at(campaign, point).empty() ? valid : wrong) = point[axis];
  }
  return upper ? 1 - valid : valid;
}

std::string describe_probability(double probability) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3g", probability);
  return text;
}

// Tries every discrete value that has a weight; the others at their medians. `at`: its place among the inputs.
void check_choices(const Campaign& campaign, const CampaignParameter& parameter, std::vector<double> inputs,
                   std::size_t at, Mistakes& mistakes) {
  const Distribution& distribution = parameter.distribution;
  double probability = 0, before = 0;
  std::string first, values;
  for (std::size_t k = 0; k < distribution.values.size(); ++k) {
    const double weight = distribution.cumulative[k] - before;
    before = distribution.cumulative[k];
    if (!(weight > 0)) continue;
    inputs[at] = distribution.values[k];
    const std::string mistake = find_mistake(campaign, make_settings(campaign, inputs));
    if (mistake.empty()) continue;
    if (first.empty()) first = mistake;
    probability += weight;
    const bool is_number = parameter.choices.empty() || !parameter.choices[k].is_scalar();
    constexpr std::size_t kLongest = 60;
    if (values.size() < kLongest)
      values += (values.empty() ? "" : ", ") + (is_number ? to_text(inputs[at]) : parameter.choices[k].text);
    else if (!values.ends_with("…"))
      values += ", …";
  }
  if (first.empty()) return;
  mistakes.add(parameter.mark,
               "parameter '" + parameter.name + "' becomes unusable with a probability of " +
                   describe_probability(probability) + ": " + first,
               "leave out what makes no valid scenario: " + values);
}

void check_ends(const Campaign& campaign, const std::vector<double>& median, Mistakes& mistakes) {
  const std::vector<double> medians = calc_inputs(campaign, median);
  std::size_t axis = 0, at = 0;
  for (const CampaignParameter& parameter : campaign.parameters) {
    const bool discrete = parameter.distribution.kind == Distribution::Kind::kDiscrete;
    if (discrete) check_choices(campaign, parameter, medians, at, mistakes);
    at += parameter.distribution.is_cone() ? 3 : 1;
    for (const bool upper : {false, true}) {
      if (discrete) break;
      std::vector<double> point = median;
      point[axis] = upper ? 1 - kLeastUnit : kLeastUnit;
      const std::string mistake = find_mistake_at(campaign, point);
      if (mistake.empty()) continue;
      mistakes.add(parameter.mark,
                   "parameter '" + parameter.name + "' becomes unusable with a probability of " +
                       describe_probability(find_probability(campaign, median, axis, upper)) + ": " + mistake,
                   "cut the distribution: `within: 3`, or min and max");
    }
    axis += parameter.distribution.get_dimensions();
  }
}

constexpr std::uint64_t kCorners = 32, kDraws = 400;

// Point of the unit cube that depends on its number alone.
std::vector<double> draw_point(const Campaign& campaign, std::uint64_t number) {
  std::vector<double> point(campaign.plan.dimensions);
  for (std::size_t axis = 0; axis < point.size(); ++axis)
    point[axis] = draw_unit(0, RandomStream::kCorner, number, static_cast<std::uint32_t>(axis));
  return point;
}

}  // namespace

std::vector<double> draw_corner(const Campaign& campaign, std::uint64_t corner) {
  std::vector<double> point = draw_point(campaign, corner);
  std::size_t axis = 0;
  for (const CampaignParameter& parameter : campaign.parameters) {
    const std::size_t end = axis + parameter.distribution.get_dimensions();
    for (; axis < end; ++axis) {
      const std::uint64_t word = draw_word(0, RandomStream::kCorner, corner, static_cast<std::uint32_t>(axis));
      if (parameter.distribution.kind != Distribution::Kind::kDiscrete)
        point[axis] = (word & 1) != 0 ? 1 - kLeastUnit : kLeastUnit;
    }
  }
  return point;
}

namespace {

// Checks values that are valid one by one but not together, such as three moments of inertia: at corners, and at as
// many draws. The probability of such values is estimated from more draws.
void check_together(const Campaign& campaign, Mistakes& mistakes) {
  std::string mistake;
  for (std::uint64_t i = 0; i < kCorners && mistake.empty(); ++i) {
    mistake = find_mistake_at(campaign, draw_corner(campaign, i));
    if (mistake.empty()) mistake = find_mistake_at(campaign, draw_point(campaign, kCorners + i));
  }
  if (mistake.empty()) return;
  int wrong = 0;
  for (std::uint64_t i = 0; i < kDraws; ++i)
    wrong += find_mistake_at(campaign, draw_point(campaign, kCorners + i)).empty() ? 0 : 1;
  constexpr double kNoneBound = 3;  // none of n: below 3/n with a confidence of 95 %
  const double draws = kDraws;
  const std::string probability =
      wrong == 0 ? "a probability below " + describe_probability(kNoneBound / draws) + " (none"
                 : "a probability of some " + describe_probability(wrong / draws) + " (" + std::to_string(wrong);
  mistakes.add(campaign.parameters.front().mark,
               "values that may be drawn together make no valid scenario, with " + probability + " of " +
                   std::to_string(kDraws) + " draws): " + mistake,
               "cut the distributions: `within: 3`, or min and max");
}

}  // namespace

void check_draws(const Campaign& campaign, Mistakes& mistakes) {
  if (campaign.parameters.empty()) return;
  if (campaign.plan.sampling == Sampling::kCsv) {
    for (std::size_t i = 0; i < campaign.table.size() && mistakes.count() == 0; ++i)
      if (const std::string mistake = find_mistake(campaign, make_settings(campaign, campaign.table[i]));
          !mistake.empty())
        mistakes.add(campaign.parameters.front().mark, "row " + std::to_string(i + 1) + " of the table: " + mistake,
                     "mend the row");
    return;
  }
  const std::vector<double> median(campaign.plan.dimensions, 0.5);
  if (!check_medians(campaign, median, mistakes)) return;
  check_ends(campaign, median, mistakes);
  if (mistakes.count() == 0) check_together(campaign, mistakes);
}

std::vector<CampaignFinding> list_findings_of_corners(const ScenarioTree& tree,
                                                      const std::vector<std::vector<Setting>>& corners) {
  std::vector<CampaignFinding> list;
  const auto add = [&](const std::vector<Setting>& settings, int number) {
    const Scenario scenario = tree.read(settings);
    for (const Finding& finding : list_findings(scenario, *build_simulation(scenario))) {
      const auto known = std::ranges::find_if(list, [&](const CampaignFinding& other) {
        return other.finding.name == finding.name && other.finding.where == finding.where;
      });
      if (known == list.end())
        list.push_back({finding, number});
      else if (known->corners > 0)
        ++known->corners;
    }
  };
  add({}, 0);
  for (const std::vector<Setting>& settings : corners) {
    try {
      add(settings, 1);
    } catch (const ScenarioError&) {  // no run begins there
    }
  }
  return list;
}

std::vector<CampaignFinding> list_campaign_findings(const Campaign& campaign) {
  std::vector<std::vector<Setting>> corners;
  const bool drawn = campaign.plan.sampling != Sampling::kCsv && !campaign.parameters.empty();
  for (int corner = 0; drawn && corner < kFindingCorners; ++corner)
    corners.push_back(
        make_settings(campaign, calc_inputs(campaign, draw_corner(campaign, static_cast<std::uint64_t>(corner)))));
  return list_findings_of_corners(*campaign.tree, corners);
}

}  // namespace unlatch::hil
