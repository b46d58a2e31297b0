// A problem of synthesis: a scenario, variables with bounds, objectives and constraints, read from a YAML file. The
// language is described in hil/scenarios/SYNTHESIS.md.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/campaign/campaign.h"
#include "hil/evaluation/evaluation.h"
#include "hil/language/quantity.h"
#include "hil/language/setting.h"
#include "hil/scenario/scenario_tree.h"

namespace unlatch::hil {

// A number between two bounds, or one entry of a catalogue; it goes to all paths.
struct DesignVariable {
  std::string name;
  std::vector<std::string> paths;
  double lower = 0, upper = 0, start = 0;  // SI; of a catalogue: indices of its entries
  Dimension dimension;                     // of the bounds; of a catalogue of numbers: of its first
  std::string unit;                        // that of SI, as the language writes it; "": none
  std::vector<YamlNode> catalogue;         // empty: continuous
  std::vector<double> numbers;             // of a catalogue of numbers: their values, SI
  SourceMark mark;

  [[nodiscard]] bool is_catalogue() const { return !catalogue.empty(); }
};

// A column of the results, or an expression of the variables.
struct Objective {
  std::string text;  // as the file has it
  bool maximise = false;
  std::string unit;  // SI
  bool is_column = false;
  std::size_t column = 0;  // of the evaluator
};

// A requirement of the nominal run, or one that a part of a campaign's samples must meet.
struct DesignConstraint {
  std::size_t requirement = 0;        // of the scenario, or of the campaign's
  std::string name, id, unit;         // name: "distance1", "distance1@0.95"; SI
  std::size_t value = 0, margin = 0;  // columns of the evaluator
  double limit = 0;                   // the scenario's: the lower one where it has two
  bool at_least = false;              // else at most
  bool both = false;                  // the requirement has two limits
  double probability = 0;             // of being met, in the campaign; 0: of the nominal run
};

// Dispersions: every design flies the same samples of a campaign (common random numbers), whose `nominal` values are
// the design's. Afterwards others of the same law check the result.
struct DesignCampaign {
  std::string file, text, folder;
  std::int64_t samples = 0, checks = 0;
  std::vector<std::string> overrides;  // of the problem's `set`
  std::shared_ptr<const Campaign> nominal;
  std::shared_ptr<const SampleEvaluator> evaluator;  // of its columns
};

enum class SearchMethod { kAuto, kLocal, kGlobal, kPareto };
extern const std::vector<std::string> kSearchMethodNames;  // "auto" …, in this order

struct DesignBudget {
  std::int64_t runs = 500;
  double seconds = 0;  // of wall time; 0: any
};

struct DesignProblem {
  std::string file, text, name, title;
  std::string scenario;                // path
  std::vector<std::string> overrides;  // PATH=VALUE: `set`
  std::vector<DesignVariable> variables;
  std::vector<Objective> objectives;
  std::vector<DesignConstraint> constraints;
  SearchMethod method = SearchMethod::kAuto;
  std::uint32_t seed = 1;
  DesignBudget budget;
  std::optional<DesignCampaign> campaign;
  std::shared_ptr<const ScenarioTree> tree;
  std::shared_ptr<const SampleEvaluator> evaluator;
};

// The text is such a problem's, not a scenario's.
bool is_design_problem(const std::string& text);

// Throws ScenarioError with every mistake of the file, of the scenario, and of the bounds: values at them that make no
// valid scenario.
DesignProblem load_design_problem(const std::string& path);
// `folder`: of the scenario.
DesignProblem load_design_problem_text(const std::string& text, const std::string& file, const std::string& folder);

// The campaign with the design's values. `check`: the other samples. Throws ScenarioError.
Campaign make_campaign(const DesignCampaign& campaign, const std::vector<Setting>& design, bool check);

// All that decides the samples of a search, so that none continues another's journal: the problem, the texts of
// scenario and campaign, their values and the version of the program.
std::uint64_t calc_fingerprint(const DesignProblem& problem);

// A point of the space of design: a number for each variable, SI; of a catalogue an index.
using DesignPoint = std::vector<double>;

std::vector<Setting> make_settings(const DesignProblem& problem, const DesignPoint& point);
// The value of one variable as the language writes it: "9000 N".
std::string write_value(const DesignVariable& variable, double value);
// Of an objective that is an expression of the variables. Throws ExpressionError.
Quantity calc_expression(const DesignProblem& problem, const Objective& objective, const DesignPoint& point);

}  // namespace unlatch::hil
