#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "hil/language/expression.h"
#include "hil/language/scenario_error.h"
#include "hil/language/scenario_sources.h"
#include "hil/language/yaml_reader.h"
#include "hil/synthesis/problem.h"

namespace unlatch::hil {
namespace {

constexpr const char* kKey = "synthesis";
constexpr std::size_t kMaxVariables = 64, kMaxObjectives = 4, kMaxCatalogue = 1000;
constexpr double kMaxRuns = 1e7, kMaxSeconds = 1e7;

// The SI unit of a dimension as the language writes it: "N", "kg m2 / s3".
std::string write_unit(const Dimension& dimension) {
  for (const std::string& name : list_unit_names()) {
    const Unit* const unit = find_unit(name);
    if (unit->factor == 1 && unit->divisor == 1 && unit->dimension == dimension && name != "%") return name;
  }
  constexpr std::array<const char*, 5> kBases{"m", "kg", "s", "rad", "Hz"};
  std::array<int, 5> exponents = dimension.exponents;
  exponents[Dimension::kTime] += exponents[Dimension::kCycle];  // a Hz is a cycle per second
  std::string above, below;
  for (std::size_t i = 0; i < kBases.size(); ++i) {
    if (exponents[i] == 0) continue;
    const std::string power =
        std::string(kBases[i]) + (std::abs(exponents[i]) == 1 ? "" : std::to_string(std::abs(exponents[i])));
    if (exponents[i] > 0)
      above += (above.empty() ? "" : " ") + power;
    else
      below += " / " + power;
  }
  return above.empty() && !below.empty() ? below.substr(1) : above + below;
}

class ProblemReader {
 public:
  ProblemReader(DesignProblem& problem, std::string folder, Mistakes& mistakes)
      : problem_(problem), folder_(std::move(folder)), mistakes_(mistakes) {}

  void read(const YamlNode& root) {
    YamlMap top(root, "the file", mistakes_);
    if (!root.is_mapping()) return;
    if (const YamlNode* version = top.require(kKey))
      if (read_number(*version, "", 1, mistakes_) != 1)
        mistakes_.add(version->mark, "a language of another version", "this program reads `synthesis: 1`");
    if (const YamlNode* name = top.require("name")) problem_.name = read_name(*name, mistakes_);
    if (const YamlNode* title = top.find("title")) problem_.title = read_text(*title, mistakes_);
    read_set(top);
    read_variables(top);
    const int method = top.choice("method", "method", kSearchMethodNames, 0);
    if (method >= 0) problem_.method = static_cast<SearchMethod>(method);
    problem_.seed = static_cast<std::uint32_t>(read_whole(top, "seed", 1, 0, 4294967295.0));
    read_budget(top);
    const YamlNode* const scenario = top.require("scenario");
    const YamlNode* const objectives = top.require("objectives");
    const YamlNode* const constraints = top.find("constraints");
    top.finish();
    if (scenario != nullptr && open_scenario(*scenario)) {
      if (constraints != nullptr)
        read_constraints(*constraints);
      else
        take_all_constraints();
      check_bounds();
      if (objectives != nullptr) read_objectives(*objectives);
    }
  }

 private:
  double read_whole(YamlMap& map, const char* key, double fallback, double least, double most) {
    const double value = map.number(key, "", fallback);
    if (value >= least && value <= most && value == std::floor(value)) return value;
    mistakes_.add(map.node().find(key)->mark, std::string("this ") + key + " is not usable",
                  "a whole number, " + to_text(least) + " to " + to_text(most));
    return fallback;
  }

  void read_set(YamlMap& top) {
    const YamlNode* const set = top.find("set");
    if (set == nullptr) return;
    YamlMap map(*set, "set", mistakes_);
    for (std::size_t i = 0; i < set->keys.size(); ++i) {
      if (set->find(set->keys[i].text) != &set->items[i]) continue;
      map.find(set->keys[i].text);
      problem_.overrides.push_back(to_text(Setting{set->keys[i].text, set->items[i]}));
    }
    map.finish();
  }

  void read_budget(YamlMap& top) {
    const YamlNode* const node = top.find("budget");
    if (node == nullptr) return;
    YamlMap map(*node, "budget", mistakes_);
    problem_.budget.runs = static_cast<std::int64_t>(read_whole(map, "runs", 500, 1, kMaxRuns));
    problem_.budget.seconds = map.number("seconds", "s", 0.0);
    if (!(problem_.budget.seconds >= 0 && problem_.budget.seconds <= kMaxSeconds))
      mistakes_.add(node->find("seconds")->mark, "this time is not usable", "0 (any) to 1e7 s");
    map.finish();
  }

  void read_variables(YamlMap& top) {
    const YamlNode* const node = top.require("variables");
    if (node == nullptr) return;
    YamlMap map(*node, "variables", mistakes_);
    if (!node->is_mapping()) return;
    if (node->keys.empty() || node->keys.size() > kMaxVariables)
      mistakes_.add(node->mark, std::to_string(node->keys.size()) + " variables", "give 1 to 64");
    for (std::size_t i = 0; i < node->keys.size(); ++i) {
      const YamlKey& key = node->keys[i];
      if (node->find(key.text) != &node->items[i]) continue;  // a duplicate: finish() says so
      map.find(key.text);
      if (!is_name(key.text) || key.text.find('-') != std::string::npos || is_reserved_name(key.text))
        mistakes_.add(key.mark, "'" + key.text + "' cannot be the name of a variable",
                      !is_name(key.text)
                          ? describe_name_rule(key.text)
                          : "expressions name variables: no '-', no unit, function or constant of the language");
      read_variable(key, node->items[i]);
    }
    map.finish();
  }

  void read_variable(const YamlKey& key, const YamlNode& node) {
    YamlMap map(node, "variable '" + key.text + "'", mistakes_);
    if (!node.is_mapping()) return;
    DesignVariable variable;
    variable.name = key.text;
    variable.mark = key.mark;
    const std::size_t before = mistakes_.count();
    const std::string where = map.only_one_of({"path", "paths"}, "a variable says which values of the scenario it is");
    if (where == "path") variable.paths.push_back(read_text(*map.find("path"), mistakes_));
    if (where == "paths") {
      const YamlNode& list = *map.find("paths");
      if (!list.is_sequence() || list.items.empty())
        mistakes_.add(list.mark, "paths is not a list", "write [PATH, PATH]");
      for (const YamlNode& item : list.items) variable.paths.push_back(read_text(item, mistakes_));
    }
    const std::string range = map.only_one_of({"between", "values"}, "a variable has bounds or a catalogue");
    if (range == "between") read_bounds(*map.find("between"), variable);
    if (range == "values") read_catalogue(*map.find("values"), variable);
    if (const YamlNode* start = map.find("start")) read_start(*start, variable, mistakes_.count() == before);
    map.finish();
    for (const std::string& path : variable.paths)
      if (!paths_.insert(path).second)
        mistakes_.add(node.mark, "'" + path + "' is varied twice", "name each path once");
    if (mistakes_.count() == before) problem_.variables.push_back(std::move(variable));
  }

  void read_bounds(const YamlNode& node, DesignVariable& variable) {
    if (!node.is_sequence() || node.items.size() != 2)
      return mistakes_.add(node.mark, "no pair of bounds", "write [LOWER, UPPER], with units: [2 kN, 20 kN]");
    const auto lower = read_quantity(node.items[0], mistakes_), upper = read_quantity(node.items[1], mistakes_);
    if (!lower || !upper) return;
    if (!(lower->dimension == upper->dimension) && lower->value != 0)
      mistakes_.add(
          node.items[1].mark,
          "the bounds are " + describe_dimension(lower->dimension) + " and " + describe_dimension(upper->dimension),
          "give both in the same kind of unit");
    else if (!(lower->value < upper->value))
      mistakes_.add(node.mark, "the lower bound is not below the upper one", "write [LOWER, UPPER]");
    variable.lower = lower->value;
    variable.upper = upper->value;
    variable.start = 0.5 * (lower->value + upper->value);
    variable.dimension = upper->dimension;
    variable.unit = write_unit(upper->dimension);
  }

  void read_catalogue(const YamlNode& node, DesignVariable& variable) {
    if (!node.is_sequence() || node.items.size() < 2 || node.items.size() > kMaxCatalogue)
      return mistakes_.add(node.mark, "no catalogue", "write a list of 2 to 1000 values");
    variable.catalogue = node.items;
    variable.upper = static_cast<double>(node.items.size() - 1);
    for (const YamlNode& item : node.items) {
      Mistakes ignored("", {});
      const auto number = item.is_scalar() ? read_quantity(item, ignored) : std::nullopt;
      if (!number || ignored.count() != 0) return variable.numbers.clear();
      if (variable.numbers.empty()) variable.dimension = number->dimension;
      variable.numbers.push_back(number->value);
    }
    variable.unit = write_unit(variable.dimension);
  }

  void read_start(const YamlNode& node, DesignVariable& variable, bool sound) {
    if (!sound) return;
    if (variable.is_catalogue()) {
      const auto same = [&](const YamlNode& item) {
        return item.is_scalar() && node.is_scalar() && item.text == node.text;
      };
      const auto found = std::find_if(variable.catalogue.begin(), variable.catalogue.end(), same);
      if (found == variable.catalogue.end())
        return mistakes_.add(node.mark, "the start is not in the catalogue", "write it as the catalogue does");
      variable.start = static_cast<double>(found - variable.catalogue.begin());
      return;
    }
    const auto start = read_quantity(node, mistakes_);
    if (!start) return;
    if (!start->dimension.is_plain() && !(start->dimension == variable.dimension))
      mistakes_.add(node.mark, "the start is " + describe_dimension(start->dimension),
                    "give it in the unit of the bounds");
    else if (!(start->value >= variable.lower && start->value <= variable.upper))
      mistakes_.add(node.mark, "the start is not within the bounds", "a value within, or none: their middle");
    variable.start = start->value;
  }

  bool open_scenario(const YamlNode& node) {
    const std::string name = read_text(node, mistakes_);
    if (name.empty()) return false;
    const std::filesystem::path path(name);
    problem_.scenario = path.is_absolute() ? name : (std::filesystem::path(folder_) / path).lexically_normal().string();
    try {
      problem_.tree = std::make_shared<ScenarioTree>(problem_.scenario, problem_.overrides);
    } catch (const ScenarioError& error) {
      for (const ScenarioMistake& mistake : error.mistakes)
        mistakes_.add(node.mark, "the scenario: " + mistake.to_string(), "`unlatch check` shows a scenario's mistakes");
      return false;
    }
    problem_.evaluator = std::make_shared<SampleEvaluator>(*problem_.tree);
    return true;
  }

  void take_constraint(std::size_t i) {
    const Requirement& requirement = problem_.tree->get_nominal().requirements[i];
    const bool at_least = std::isfinite(requirement.least), at_most = std::isfinite(requirement.most);
    problem_.constraints.push_back({i, requirement.id, requirement.unit, *problem_.evaluator->find(requirement.id),
                                    *problem_.evaluator->find(requirement.id + ".margin"),
                                    at_least ? requirement.least : requirement.most, at_least, at_least && at_most});
  }

  void take_all_constraints() {
    for (std::size_t i = 0; i < problem_.tree->get_nominal().requirements.size(); ++i) take_constraint(i);
  }

  void read_constraints(const YamlNode& node) {
    if (node.is_scalar() && node.text == "all") return take_all_constraints();
    if (!node.is_sequence())
      return mistakes_.add(node.mark, "constraints is not a list",
                           "write `all` or the ids of requirements: [R1, R2]; [] for none");
    std::vector<std::string> known;
    for (const Requirement& requirement : problem_.tree->get_nominal().requirements) known.push_back(requirement.id);
    std::set<int> taken;
    for (const YamlNode& item : node.items) {
      const int found = read_choice(item, "requirement", known, mistakes_);
      if (found < 0) continue;
      if (!taken.insert(found).second)
        mistakes_.add(item.mark, "'" + item.text + "' is named twice", "name each once");
      else
        take_constraint(static_cast<std::size_t>(found));
    }
  }

  void read_objectives(const YamlNode& node) {
    if (!node.is_sequence() || node.items.empty() || node.items.size() > kMaxObjectives)
      return mistakes_.add(node.mark, "no list of objectives", "write 1 to 4: [{minimise: QUANTITY}]");
    for (const YamlNode& item : node.items) {
      YamlMap map(item, "an objective", mistakes_);
      if (!item.is_mapping()) continue;
      const std::string sense = map.only_one_of({"minimise", "maximise"}, "an objective has a sense");
      if (!sense.empty()) read_objective(*map.find(sense), sense == "maximise");
      map.finish();
    }
    if (problem_.objectives.size() > 1 &&
        (problem_.method == SearchMethod::kLocal || problem_.method == SearchMethod::kGlobal))
      mistakes_.add(node.mark, "several objectives", "method `pareto` or `auto`; or one objective");
    if (problem_.objectives.size() == 1 && problem_.method == SearchMethod::kPareto)
      mistakes_.add(node.mark, "one objective has no Pareto front", "give several, or another method");
  }

  void read_objective(const YamlNode& node, bool maximise) {
    Objective objective{read_text(node, mistakes_), maximise, "", false, 0};
    if (objective.text.empty()) return;
    const SampleEvaluator& evaluator = *problem_.evaluator;
    if (const auto column = evaluator.find(objective.text)) {
      objective.is_column = true;
      objective.column = *column;
      objective.unit = evaluator.columns()[*column].unit;
      problem_.objectives.push_back(objective);
      return;
    }
    std::vector<std::string> known;
    for (const ResultColumn& column : evaluator.columns()) known.push_back(column.name);
    for (const DesignVariable& variable : problem_.variables) known.push_back(variable.name);
    try {
      DesignPoint start;
      for (const DesignVariable& variable : problem_.variables) start.push_back(variable.start);
      objective.unit = write_unit(calc_expression(problem_, objective, start).dimension);
      problem_.objectives.push_back(objective);
    } catch (const ExpressionError& error) {
      mistakes_.add(node.mark,
                    "'" + objective.text +
                        "' is neither a result of the scenario nor an expression of the variables: " + error.what(),
                    suggest(objective.text, known));
    }
  }

  // Each end of each variable, the others at their start: what the scenario's own reader says of it.
  void check_bounds() {
    DesignPoint start;
    for (const DesignVariable& variable : problem_.variables) start.push_back(variable.start);
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const DesignVariable& variable = problem_.variables[i];
      std::vector<double> ends{variable.lower, variable.upper};
      for (std::size_t k = 1; k + 1 < variable.catalogue.size(); ++k) ends.push_back(static_cast<double>(k));
      std::set<std::string> told;
      for (const double end : ends) {
        DesignPoint point = start;
        point[i] = end;
        try {
          (void)problem_.tree->read(make_settings(problem_, point));
        } catch (const ScenarioError& error) {
          const ScenarioMistake& first = error.mistakes.front();
          if (told.insert(first.what).second)
            mistakes_.add(
                variable.mark,
                "'" + variable.name + "' at " + write_value(variable, end) + " makes no valid scenario: " + first.what,
                first.mend);
        }
      }
    }
  }

  DesignProblem& problem_;
  const std::string folder_;
  Mistakes& mistakes_;
  std::set<std::string> paths_;
};

}  // namespace

bool is_design_problem(const std::string& text) {
  try {
    const YamlNode root = parse_yaml(text);
    return root.is_mapping() && root.find(kKey) != nullptr && root.find("unlatch") == nullptr;
  } catch (const YamlError&) {
    return false;
  }
}

DesignProblem load_design_problem_text(const std::string& text, const std::string& file, const std::string& folder) {
  DesignProblem problem;
  problem.file = file;
  problem.text = text;
  Mistakes mistakes(file, {});
  try {
    ProblemReader(problem, folder, mistakes).read(parse_yaml(text));
  } catch (const YamlError& error) {
    mistakes.add(error.mark, error.what(), error.mend);
  }
  mistakes.throw_if_any();
  return problem;
}

DesignProblem load_design_problem(const std::string& path) {
  return load_design_problem_text(read_text_file(path, "synthesis"), path,
                                  std::filesystem::path(path).parent_path().string());
}

}  // namespace unlatch::hil
