// Check that the values which a campaign may draw make valid scenarios: tried at the ends of each parameter, and at
// corners of all.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "hil/campaign/campaign_reader.h"
#include "hil/sampling/philox.h"

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

void check_ends(const Campaign& campaign, const std::vector<double>& median, Mistakes& mistakes) {
  std::size_t axis = 0;
  for (const CampaignParameter& parameter : campaign.parameters) {
    for (const bool upper : {false, true}) {
      std::vector<double> point = median;
      point[axis] = upper ? 1 - kLeastUnit : kLeastUnit;
      const std::string mistake = find_mistake_at(campaign, point);
      if (mistake.empty()) continue;
      char text[64];
      std::snprintf(text, sizeof text, "%.3g", find_probability(campaign, median, axis, upper));
      mistakes.add(parameter.mark,
                   "parameter '" + parameter.name + "' becomes unusable with a probability of " + text + ": " + mistake,
                   "cut the distribution: `within: 3`, or min and max");
    }
    axis += parameter.distribution.get_dimensions();
  }
}

// Checks values that are valid one by one but not together, such as three moments of inertia.
void check_corners(const Campaign& campaign, Mistakes& mistakes) {
  constexpr std::uint64_t kCorners = 32;
  for (std::uint64_t corner = 0; corner < kCorners; ++corner) {
    std::vector<double> point(campaign.plan.dimensions);
    for (std::size_t axis = 0; axis < point.size(); ++axis) {
      const std::uint64_t word = draw_word(0, RandomStream::kCorner, corner, static_cast<std::uint32_t>(axis));
      point[axis] = (word & 1) != 0 ? 1 - kLeastUnit : kLeastUnit;
    }
    const std::string mistake = find_mistake_at(campaign, point);
    if (mistake.empty()) continue;
    return mistakes.add(campaign.parameters.front().mark,
                        "values that may be drawn together make no valid scenario: " + mistake,
                        "cut the distributions: `within: 3`, or min and max");
  }
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
  if (mistakes.count() == 0) check_corners(campaign, mistakes);
}

}  // namespace unlatch::hil
