// A campaign: a scenario, how many samples, how they are drawn, and what varies, read from a YAML file. The language is
// described in hil/scenarios/CAMPAIGNS.md.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/language/setting.h"
#include "hil/sampling/distribution.h"
#include "hil/sampling/sampling.h"
#include "hil/scenario/scenario_tree.h"

namespace unlatch::hil {

// One draw, and the paths that it goes to.
struct CampaignParameter {
  std::string name;                // "thrust", or "thrust:1" for one of the entries that a path with * meets
  std::vector<std::string> paths;  // one for those that are not shared
  Distribution distribution;
  std::array<double, 3> direction{};  // of a cone: its axis
  std::vector<YamlNode> choices;      // of discrete values that are no numbers: the draw is the index of one
  std::string unit;                   // of its numbers, as SI units: "kg m2", "" if the file gives none
  int levels = 0;                     // of a grid and of one-at-a-time
  SourceMark mark;
  bool drawn = true;  // false: its values come from a table
};

struct Correlation {
  std::size_t a = 0, b = 0;  // parameters
  double rho = 0;            // of the underlying normal numbers
};

// Of subset sampling: the failure that it looks for, and its levels.
struct RareFailure {
  std::string column, unit;      // of the results
  std::size_t column_index = 0;  // among all of the scenario
  double limit = 0;              // in that unit; a value that is below it fails
  bool above = false;            // one that is above it
  std::int64_t samples = 0;      // of a level
  std::int64_t chains = 0;       // of a level: its samples times the part that goes on to the next
  int levels = 1;                // at most
  double at_most = 1;            // probability that is allowed
};

struct Campaign {
  std::string file, text;  // the campaign file as it is
  std::string folder;      // of the files that it names
  std::string name, title;
  std::string scenario;  // path
  SamplingPlan plan;
  std::vector<CampaignParameter> parameters;
  std::vector<Correlation> correlations;
  std::vector<double> factor;              // Cholesky factor of the correlations, by rows; empty: none
  std::vector<std::vector<double>> table;  // of sampling `csv`: a row for each sample
  std::optional<RareFailure> failure;      // of sampling `subset`
  std::shared_ptr<const ScenarioTree> tree;
};

// The text is a campaign's, not a scenario's.
bool is_campaign(const std::string& text);

// Throws ScenarioError with every mistake of the file, of the scenario, and of the values that may be drawn: a value
// that the generator can give and that makes no valid scenario is a mistake, told with its probability. `overrides` go
// to the scenario, after the campaign's own `set`.
Campaign load_campaign(const std::string& path, const std::vector<std::string>& overrides = {});
// `folder`: of the scenario and the tables.
Campaign load_campaign_text(const std::string& text, const std::string& file, const std::string& folder,
                            const std::vector<std::string>& overrides = {});

// Names of the inputs, one for each number: a direction has three, "axis.x" and so on.
struct InputColumn {
  std::string name, unit;
};
std::vector<InputColumn> list_inputs(const Campaign& campaign);

// The inputs of one sample, from 0: they depend on the file, its seed and the number alone. Of subset sampling this is
// so for the first level; the others follow from results (SampleSource). Throws std::out_of_range for them.
std::vector<double> draw_inputs(const Campaign& campaign, std::int64_t sample);
// Those at one point of the unit cube.
std::vector<double> calc_inputs(const Campaign& campaign, const std::vector<double>& point);
// The scenario's values of these inputs.
std::vector<Setting> make_settings(const Campaign& campaign, const std::vector<double>& inputs);

}  // namespace unlatch::hil
