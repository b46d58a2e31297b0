// A campaign: a scenario, the number of samples, the sampling method, and the parameters that vary, read from a YAML
// file. hil/scenarios/CAMPAIGNS.md describes the language.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/scenario/scenario_tree.h"
#include "hil/scenario/text/written_unit.h"
#include "hil/scenario/yaml/setting.h"
#include "hil/study/evaluation/chosen_outputs.h"
#include "hil/study/evaluation/step_search.h"
#include "hil/study/sampling/distribution.h"
#include "hil/study/sampling/sampling.h"

namespace unlatch::hil {

// One drawn value, and the paths that it sets.
struct CampaignParameter {
  std::string name;                // "thrust", or "thrust:1" for one of the entries that match a path with *
  std::vector<std::string> paths;  // one path, unless several share the value
  Distribution distribution;
  std::array<double, 3> direction{};  // axis of a cone
  std::vector<YamlNode> choices;      // discrete values other than numbers: the draw is the index of one
  std::vector<std::size_t> columns;   // of discrete rows: the column of each path; then `choices` has sequences
  std::string unit;                   // unit of its numbers, SI: "kg m2", "" for plain numbers
  std::optional<WrittenUnit> shown;   // unit in which the file gives them
  int levels = 0;                     // levels of a grid or of one-at-a-time
  SourceMark mark;
  bool drawn = true;  // false: the values come from a table
};

struct Correlation {
  std::size_t a = 0, b = 0;  // parameters
  double rho = 0;            // correlation of the underlying normal numbers
};

// Failure that subset sampling estimates, and its levels.
struct RareFailure {
  std::string column, unit;      // column of the results
  std::size_t column_index = 0;  // index among all columns of the scenario
  double limit = 0;              // in that unit; a value below it fails
  bool above = false;            // a value above the limit fails instead
  std::int64_t samples = 0;      // samples of a level
  std::int64_t chains = 0;       // chains of a level: its samples times the part that seeds the next level
  int levels = 1;                // levels at most
  double at_most = 1;            // allowed probability
};

struct Campaign {
  std::string file, text;  // the campaign file, unchanged
  std::string folder;      // folder of the files that it names
  std::string name, title;
  std::string scenario;  // path
  SamplingPlan plan;
  std::vector<CampaignParameter> parameters;
  std::vector<Correlation> correlations;
  std::vector<double> factor;              // Cholesky factor of the correlations, by rows; empty: none
  std::vector<std::vector<double>> table;  // rows of sampling `csv`, one for each sample
  std::optional<RareFailure> failure;      // only for sampling `subset`
  ChosenOutputs chosen;                    // columns besides those of every run; for the SampleEvaluator
  double tolerance = 0;                    // relative, of the values that are judged; 0: the scenario's step is flown
  std::optional<StepSearch> step_search;   // what choose_step() found for it
  std::vector<std::string> remarks;        // no mistakes, but worth knowing
  std::shared_ptr<const ScenarioTree> tree;
};

// Returns true if the text is a campaign, false if it is a scenario.
bool is_campaign(const std::string& text);

// Loads a campaign. Throws ScenarioError with every mistake of the file, of the scenario, and of the values that may be
// drawn: a value that the generator can give and that makes no valid scenario is a mistake, reported with its
// probability. `overrides` apply to the scenario, after the campaign's own `set`.
Campaign load_campaign(const std::string& path, const std::vector<std::string>& overrides = {});
// `folder`: folder of the scenario and the tables.
Campaign load_campaign_text(const std::string& text, const std::string& file, const std::string& folder,
                            const std::vector<std::string>& overrides = {});

// Names of the inputs, one for each number: a direction has three, "axis.x" and so on.
struct InputColumn {
  std::string name, unit;
  std::optional<WrittenUnit> shown{};
  bool is_category = false;  // an index of things in no order
};
std::vector<InputColumn> list_inputs(const CampaignParameter& parameter);
std::vector<InputColumn> list_inputs(const Campaign& campaign);

// Unit in which the campaign's scenario gives the limits of a requirement, or a constant that is one.
std::optional<WrittenUnit> find_shown_unit(const Campaign& campaign, const std::string& requirement);

// Inputs of one sample, numbered from 0: they depend on the file, its seed and the number alone. For subset sampling
// this holds for the first level only; the other levels follow from results (SampleSource), and the function throws
// std::out_of_range for them.
std::vector<double> draw_inputs(const Campaign& campaign, std::int64_t sample);
// Inputs at one point of the unit cube.
std::vector<double> calc_inputs(const Campaign& campaign, const std::vector<double>& point);
// Settings of the scenario for these inputs.
std::vector<Setting> make_settings(const Campaign& campaign, const std::vector<double>& inputs);

}  // namespace unlatch::hil
