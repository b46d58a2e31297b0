// an optimisation problem: a scenario, variables with bounds, objectives and constraints, read from a YAML file.
// hil/scenarios/OPTIMIZE.md describes the language.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/scenario/scenario_tree.h"
#include "hil/scenario/text/quantity.h"
#include "hil/scenario/yaml/setting.h"
#include "hil/study/campaign/campaign.h"
#include "hil/study/evaluation/evaluation.h"

namespace unlatch::hil {

// A number between two bounds, or one entry of a catalogue, which all paths get; or one row of a catalogue, of which
// each path gets the value in its column: stiffness, preload and stroke of a real spring belong together.
struct OptimizeVariable {
  std::string name;
  std::vector<std::string> paths;
  double lower = 0, upper = 0, start = 0;  // SI; for a catalogue: indices of its entries
  Dimension dimension;                     // dimension of the bounds; for a catalogue of numbers: of its first entry
  std::string unit;                        // SI unit, as the language writes it; "": none
  std::vector<YamlNode> catalogue;         // empty: continuous
  std::vector<double> numbers;             // values of a catalogue of numbers, SI
  std::vector<std::size_t> columns;        // of rows: the column of each path; then `catalogue` has sequences
  std::vector<std::string> titles;         // of rows: names of the columns in expressions; may be empty
  std::vector<std::vector<Quantity>> row_numbers;  // of rows with titles: their values
  SourceMark mark;

  [[nodiscard]] bool is_catalogue() const { return !catalogue.empty(); }
};

// A column of the results, or an expression of the variables.
struct Objective {
  std::string text;  // text in the file
  bool maximise = false;
  std::string unit;  // SI
  bool is_column = false;
  std::size_t column = 0;  // column of the evaluator
};

// A requirement of the nominal run, or one that a part of a campaign's samples must meet.
struct OptimizeConstraint {
  std::size_t requirement = 0;        // index in the scenario, or in the campaign's scenario
  std::string name, id, unit;         // name: "distance1", "distance1@0.95"; SI
  std::size_t value = 0, margin = 0;  // columns of the evaluator
  double limit = 0;                   // limit of the scenario; that of a design may differ (calc_limits)
  bool at_least = false;              // false: at most
  bool both = false;                  // the requirement has two limits
  double probability = 0;             // required probability in the campaign; 0: constraint of the nominal run
};

// Dispersions: every design is run with the same samples of a campaign (common random numbers), whose `nominal` values
// are the design's. Afterwards other samples of the same distributions check the result.
struct OptimizeCampaign {
  std::string file, text, folder;
  std::int64_t samples = 0, checks = 0;
  std::int64_t most = 0;               // the search's samples grow to these where fresh ones do not confirm its verdict
  std::vector<std::string> overrides;  // overrides of the problem's `set`
  std::shared_ptr<const Campaign> nominal;
  std::shared_ptr<const SampleEvaluator> evaluator;  // evaluator of the campaign's columns
};

enum class SearchMethod { kAuto, kLocal, kGlobal, kPareto };
extern const std::vector<std::string> kSearchMethodNames;  // "auto" …, in the order of the enum

struct OptimizeBudget {
  std::int64_t runs = 500;
  double seconds = 0;  // s of wall time; 0: no limit
};

struct OptimizeProblem {
  std::string file, text, name, title;
  std::string scenario;                // path
  std::vector<std::string> overrides;  // PATH=VALUE: `set`
  std::vector<OptimizeVariable> variables;
  // Paths of constants that objectives alone read, by their variables' names: runs of the scenario do not get them.
  std::vector<std::string> of_objectives;
  std::vector<Objective> objectives;
  std::vector<OptimizeConstraint> constraints;
  SearchMethod method = SearchMethod::kAuto;
  std::int64_t starts = 1;  // of the local search
  std::uint32_t seed = 1;
  OptimizeBudget budget;
  std::optional<OptimizeCampaign> campaign;
  double tolerance = 0;                   // relative, of objectives and constraints; 0: the scenario's step is flown
  std::optional<StepSearch> step_search;  // what choose_step() found for it
  std::shared_ptr<const ScenarioTree> tree;
  std::shared_ptr<const SampleEvaluator> evaluator;
};

// Returns true if the text is an optimisation problem, false if it is a scenario.
bool is_optimize_problem(const std::string& text);

// Loads a problem. Throws ScenarioError with every mistake of the file, of the scenario, and of the bounds: values at
// them that make no valid scenario.
OptimizeProblem load_optimize_problem(const std::string& path);
// `folder`: folder of the scenario.
OptimizeProblem load_optimize_problem_text(const std::string& text, const std::string& file, const std::string& folder);

// Samples that a design flies: their number, and which ones: 0 are those of the search, others are fresh.
struct OptimizeFlights {
  std::int64_t samples = 0;
  std::uint64_t stream = 0;
};
// Campaign with the design's values. Throws ScenarioError.
Campaign make_campaign(const OptimizeCampaign& campaign, const std::vector<Setting>& design,
                       const OptimizeFlights& flights);

// Hash of everything that determines the samples of a search, so that none continues another's journal: the problem,
// the texts of scenario and campaign, their values and the version of the program.
std::uint64_t calc_fingerprint(const OptimizeProblem& problem);

// A point of the design space: a number for each variable, SI; for a catalogue an index.
using OptimizePoint = std::vector<double>;

OptimizePoint get_start(const OptimizeProblem& problem);
std::vector<Setting> make_settings(const OptimizeProblem& problem, const OptimizePoint& point);
// Value of one variable as the language writes it: "9000 N".
std::string write_value(const OptimizeVariable& variable, double value);
// Limit of a requirement: the lower one if it has two.
double get_limit(const Requirement& requirement);
// Limits of the constraints of a design, whose variables may be limits, or values from which limits are computed. Those
// of the scenario if the design makes no valid one.
std::vector<double> calc_limits(const OptimizeProblem& problem, const OptimizePoint& point);
// Value of an objective that is an expression of the variables. Throws ExpressionError.
Quantity calc_expression(const OptimizeProblem& problem, const Objective& objective, const OptimizePoint& point);
// True if an objective of this text reads the variable, or the column of a catalogue's rows: a column of the results
// reads none, whatever words its name has.
bool reads_variable(const OptimizeProblem& problem, const std::string& text, const std::string& name);

}  // namespace unlatch::hil
