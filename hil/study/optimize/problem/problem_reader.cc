#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/text/count.h"
#include "hil/scenario/text/expression.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "hil/scenario/yaml/yaml_override.h"
#include "hil/scenario/yaml/yaml_reader.h"
#include "hil/study/optimize/problem/problem.h"
#include "hil/study/optimize/problem/variable_reader.h"

namespace unlatch::hil {
namespace {

constexpr const char* kKey = "unlatch_optimize";
constexpr const char* kEarlierKey = "unlatch_synthesis";  // of files that are older; it means the same
constexpr std::size_t kMaxObjectives = 4;
constexpr double kMaxRuns = 1e7, kMaxSeconds = 1e7, kMaxSamples = 1e6, kMaxStarts = 1000;
constexpr double kDefaultSamples = 64, kChecks = 4, kGrowth = 16;  // the latter two: multiples of the samples

class ProblemReader {
 public:
  ProblemReader(OptimizeProblem& problem, std::string folder, Mistakes& mistakes)
      : problem_(problem), folder_(std::move(folder)), mistakes_(mistakes) {}

  void read(const YamlNode& root) {
    if (root.is_mapping() && root.find(kKey) == nullptr && root.find(kEarlierKey) == nullptr &&
        root.find("unlatch") != nullptr)
      return mistakes_.add(root.mark, "this is a scenario, not an optimisation problem",
                           "`unlatch run` flies it; an optimisation problem names it: `scenario: FILE`");
    YamlMap top(root, "the file", mistakes_);
    if (!root.is_mapping()) return;
    top.read_header(root.find(kEarlierKey) != nullptr ? kEarlierKey : kKey);
    if (const YamlNode* name = top.require("name")) problem_.name = read_name(*name, mistakes_);
    if (const YamlNode* title = top.find("title")) problem_.title = read_text(*title, mistakes_);
    read_set(top);
    problem_.tolerance = read_bounded(top, get_number_key("optimize.optimize.tolerance"), 0.0, mistakes_);
    const std::size_t before = mistakes_.count();
    read_variables(top, problem_, mistakes_);
    variables_sound_ = mistakes_.count() == before;
    const int method = top.choice("method", "method", kSearchMethodNames, 0);
    if (method >= 0) problem_.method = static_cast<SearchMethod>(method);
    problem_.seed = static_cast<std::uint32_t>(read_whole(top, "seed", 1, 0, 4294967295.0));
    problem_.starts = static_cast<std::int64_t>(read_whole(top, "starts", 1, 1, kMaxStarts));
    read_budget(top);
    const YamlNode* const scenario = top.require("scenario");
    const YamlNode* const objectives = top.require("objectives");
    const YamlNode* const constraints = top.find("constraints");
    const YamlNode* const campaign = top.find("campaign");
    top.finish();
    if (scenario != nullptr && open_scenario(*scenario)) {
      refuse_names_of_results();
      refuse_flight_software(*scenario, problem_.tree->get_nominal());
      refuse_plain_numbers();
      if (campaign != nullptr) read_campaign(*campaign);
      if (objectives != nullptr) find_constants_of_objectives(*objectives);
      if (constraints != nullptr)
        read_constraints(*constraints);
      else
        take_all_constraints();
      check_bounds();
      check_campaign();
      if (objectives != nullptr) read_objectives(*objectives);
    }
    check_starts(root);
  }

 private:
  double read_whole(YamlMap& map, const char* key, double fallback, double least, double most) {
    const double value = map.number(key, "", fallback);
    if (value >= least && value <= most && value == std::floor(value)) return value;
    mistakes_.add(map.node().find(key)->mark, std::string("'") + key + "' is out of range",
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

  // Refuses starts that no local search would use.
  void check_starts(const YamlNode& root) {
    if (problem_.starts == 1) return;
    const bool automatic = problem_.method == SearchMethod::kAuto;
    const bool continuous = std::ranges::none_of(problem_.variables, &OptimizeVariable::is_catalogue);
    if (problem_.method == SearchMethod::kLocal || (automatic && continuous && problem_.objectives.size() <= 1)) return;
    mistakes_.add(root.find("starts")->mark, "several starts, and no local search",
                  automatic ? "method: local; catalogues and several objectives have searches of the whole box"
                            : "leave `starts` out, or method: local");
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

  // Refuses variables that an objective could not distinguish from a result.
  void refuse_names_of_results() {
    for (const OptimizeVariable& variable : problem_.variables)
      if (problem_.evaluator->find(variable.name))
        mistakes_.add(variable.mark, "'" + variable.name + "' is a result of the scenario, such as a requirement, too",
                      "give the variable another name, so that an objective can mean either");
  }

  // A plain number for a constant that the scenario gives in millimetres would be one of metres.
  void refuse_plain_numbers() {
    for (const OptimizeVariable& variable : problem_.variables)
      for (std::size_t k = 0; k < variable.paths.size(); ++k) {
        const auto unit = find_constant_unit(problem_.tree->get_root(), variable.paths[k]);
        if (unit && gives_plain_number(variable, k))
          mistakes_.add(variable.mark,
                        "plain numbers for '" + variable.paths[k] + "', which the scenario gives in " + unit->name,
                        "write the unit: 1 " + unit->name + ", or that of SI");
      }
  }

  // True if a value of the variable for its path number k is a number without a unit, other than 0.
  static bool gives_plain_number(const OptimizeVariable& variable, std::size_t k) {
    if (!variable.is_catalogue()) return variable.dimension.is_plain();
    return std::ranges::any_of(variable.catalogue, [&](const YamlNode& item) {
      const YamlNode& own = variable.columns.empty() ? item : item.items.at(variable.columns[k]);
      Mistakes ignored("", {});
      const auto number = own.is_scalar() ? read_quantity(own, ignored) : std::nullopt;
      return number && number->dimension.is_plain() && number->value != 0;
    });
  }

  // Constants of variables that objectives name and neither the scenario nor the campaign's reads.
  void find_constants_of_objectives(const YamlNode& objectives) {
    const auto is_unread = [&](const std::string& path) {
      return is_unread_constant(problem_.tree->get_root(), path) &&
             (!problem_.campaign || is_unread_constant(problem_.campaign->nominal->tree->get_root(), path));
    };
    for (const OptimizeVariable& variable : problem_.variables)
      for (std::size_t k = 0; k < variable.paths.size(); ++k) {
        std::string name = variable.name;
        if (!variable.columns.empty()) name = variable.titles.empty() ? "" : variable.titles.at(variable.columns[k]);
        if (!name.empty() && is_unread(variable.paths[k]) && names_variable(objectives, name))
          problem_.of_objectives.push_back(variable.paths[k]);
      }
  }

  // True if an expression among the objectives reads the variable.
  bool names_variable(const YamlNode& node, const std::string& name) const {
    if (node.is_scalar()) return variables_sound_ && reads_variable(problem_, node.text, name);
    return std::ranges::any_of(node.items, [&](const YamlNode& item) { return names_variable(item, name); });
  }

  // Refuses a scenario whose flight software would have to take part.
  void refuse_flight_software(const YamlNode& node, const Scenario& scenario) {
    const std::string absent = describe_absence(scenario.flight_software, "a search");
    if (!absent.empty())
      mistakes_.add(node.mark, absent, "if that is what you mean, write set: {flight_software.required: []}");
  }

  // Reads FILE, or {file: FILE, samples: N, checks: N}.
  void read_campaign(const YamlNode& node) {
    OptimizeCampaign campaign;
    campaign.samples = static_cast<std::int64_t>(kDefaultSamples);
    campaign.checks = static_cast<std::int64_t>(kChecks * kDefaultSamples);
    campaign.most = static_cast<std::int64_t>(kGrowth * kDefaultSamples);
    const YamlNode* file = &node;
    if (!node.is_scalar()) {
      YamlMap map(node, "campaign", mistakes_);
      if (!node.is_mapping()) return;
      file = map.require("file");
      campaign.samples = static_cast<std::int64_t>(read_whole(map, "samples", kDefaultSamples, 2, kMaxSamples));
      campaign.checks = static_cast<std::int64_t>(
          read_whole(map, "checks", kChecks * static_cast<double>(campaign.samples), 0, kMaxSamples));
      const auto least = static_cast<double>(campaign.samples);
      campaign.most = static_cast<std::int64_t>(
          read_whole(map, "most", std::min(kGrowth * least, kMaxSamples), least, kMaxSamples));
      map.finish();
    }
    if (file == nullptr) return;
    const std::filesystem::path path = std::filesystem::path(folder_) / read_text(*file, mistakes_);
    campaign.file = path.lexically_normal().string();
    campaign.folder = std::filesystem::path(campaign.file).parent_path().string();
    campaign.overrides = problem_.overrides;
    try {
      campaign.text = read_text_file(campaign.file, "campaign");
      campaign.nominal = std::make_shared<Campaign>(make_campaign(campaign, {}, {campaign.samples}));
    } catch (const ScenarioError& error) {
      for (const ScenarioMistake& mistake : error.mistakes)
        mistakes_.add(file->mark, "the campaign: " + mistake.to_string(),
                      "`unlatch check` shows a campaign's mistakes");
      return;
    }
    refuse_flight_software(*file, campaign.nominal->tree->get_nominal());
    if (campaign.nominal->tolerance > 0)
      mistakes_.add(file->mark, "the campaign has a tolerance of its own",
                    "`tolerance` in this file: a search flies all its runs at one step");
    const Sampling sampling = campaign.nominal->plan.sampling;
    if (sampling != Sampling::kRandom && sampling != Sampling::kLatinHypercube && sampling != Sampling::kSobol)
      return mistakes_.add(file->mark, "its sampling draws no probabilities",
                           "`random`, `latin-hypercube` or `sobol` in the campaign's file");
    campaign.evaluator = std::make_shared<SampleEvaluator>(*campaign.nominal->tree);
    problem_.campaign = std::move(campaign);
  }

  void take_constraint(std::size_t i, double probability = 0) {
    const ScenarioTree& tree = probability > 0 ? *problem_.campaign->nominal->tree : *problem_.tree;
    const SampleEvaluator& evaluator = probability > 0 ? *problem_.campaign->evaluator : *problem_.evaluator;
    const Requirement& requirement = tree.get_nominal().requirements[i];
    const bool at_least = std::isfinite(requirement.least), at_most = std::isfinite(requirement.most);
    const std::string name = requirement.id + (probability > 0 ? "@" + to_text(probability) : "");
    problem_.constraints.push_back({i, name, requirement.id, requirement.unit, *evaluator.find(requirement.id),
                                    *evaluator.find(requirement.id + ".margin"), get_limit(requirement), at_least,
                                    at_least && at_most, probability});
  }

  void take_all_constraints() {
    for (std::size_t i = 0; i < problem_.tree->get_nominal().requirements.size(); ++i) take_constraint(i);
  }

  void read_constraints(const YamlNode& node) {
    if (node.is_scalar() && node.text == "all") return take_all_constraints();
    if (!node.is_sequence())
      return mistakes_.add(node.mark, "constraints is not a list",
                           "write `all` or the ids of requirements: [R1, R2]; [] for none");
    const std::vector<std::string> known = list_requirements(*problem_.tree);
    for (const YamlNode& item : node.items) {
      if (item.is_mapping()) {
        read_robust_constraint(item);
        continue;
      }
      const int found = read_choice(item, "requirement", known, mistakes_);
      if (found >= 0) take_constraint(static_cast<std::size_t>(found));
      refuse_twice(item);
    }
  }

  static std::vector<std::string> list_requirements(const ScenarioTree& tree) {
    std::vector<std::string> ids;
    for (const Requirement& requirement : tree.get_nominal().requirements) ids.push_back(requirement.id);
    return ids;
  }

  // Refuses a repetition in the last item, which `node` has given.
  void refuse_twice(const YamlNode& node) {
    for (std::size_t i = 0; i + 1 < problem_.constraints.size(); ++i)
      if (problem_.constraints[i].name == problem_.constraints.back().name) {
        mistakes_.add(node.mark, "'" + problem_.constraints[i].name + "' is named twice", "name each once");
        problem_.constraints.pop_back();
        return;
      }
  }

  // Reads {requirement: ID, probability: P}, of the campaign.
  void read_robust_constraint(const YamlNode& node) {
    YamlMap map(node, "a constraint", mistakes_);
    const YamlNode* const id = map.require("requirement");
    const double probability = map.number("probability", "");
    map.finish();
    if (id == nullptr || map.node().find("probability") == nullptr) return;
    const SourceMark mark = map.node().find("probability")->mark;
    if (!problem_.campaign) {
      if (node.find("requirement") != nullptr && !campaign_reported_)
        mistakes_.add(node.mark, "a probability without a usable campaign",
                      "name one at the top: campaign: {file: campaign.yaml, samples: 64}");
      campaign_reported_ = true;
      return;
    }
    if (!(probability > 0 && probability < 1))
      return mistakes_.add(mark, "no probability", "a number between 0 and 1, such as 0.95");
    const auto least = static_cast<std::int64_t>(std::ceil(1 / (1 - probability) - 1e-9));
    if (problem_.campaign->samples < least)
      mistakes_.add(mark, count(problem_.campaign->samples, "sample") + " cannot show this probability",
                    "samples: " + std::to_string(least) + " or more");
    const int found = read_choice(*id, "requirement of the campaign",
                                  list_requirements(*problem_.campaign->nominal->tree), mistakes_);
    if (found < 0) return;
    take_constraint(static_cast<std::size_t>(found), probability);
    if (problem_.constraints.back().both)
      mistakes_.add(id->mark, "a requirement with two limits", "one with `at_least`, and one with `at_most`");
    refuse_twice(node);
  }

  void read_objectives(const YamlNode& node) {
    if (!node.is_sequence() || node.items.empty() || node.items.size() > kMaxObjectives)
      return mistakes_.add(node.mark, "no list of objectives", "write 1 to 4: [{minimise: QUANTITY}]");
    for (const YamlNode& item : node.items) {
      YamlMap map(item, "an objective", mistakes_);
      if (!item.is_mapping()) continue;
      const std::string sense = map.only_one_of({"minimise", "maximise"}, "a sense");
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
    if (!variables_sound_) return;  // the expression may use a variable that has a mistake
    std::vector<std::string> known;
    for (const ResultColumn& column : evaluator.columns()) known.push_back(column.name);
    for (const OptimizeVariable& variable : problem_.variables) known.push_back(variable.name);
    try {
      objective.unit = describe_objective(calc_expression(problem_, objective, get_start(problem_)).dimension);
      problem_.objectives.push_back(objective);
    } catch (const ExpressionError& error) {
      mistakes_.add(node.mark,
                    "'" + objective.text +
                        "' is neither a result of the scenario nor an expression of the variables: " + error.what(),
                    suggest(objective.text, known));
    }
  }

  // Description of an objective. A force times a length is an energy, unless a variable of the problem is a torque.
  [[nodiscard]] std::string describe_objective(const Dimension& dimension) const {
    const bool torque = std::ranges::any_of(
        problem_.variables, [&](const OptimizeVariable& variable) { return variable.dimension == dimension; });
    return !torque && dimension == find_unit("J")->dimension ? "J" : describe_unit(dimension);
  }

  // Checks each end of each variable, with the scenario's own values of the others; then the start. The scenario's own
  // reader reports the mistakes.
  void check_bounds() {
    const std::size_t before = mistakes_.count();
    const OptimizePoint start = get_start(problem_);
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const OptimizeVariable& variable = problem_.variables[i];
      std::vector<double> ends{variable.lower, variable.upper};
      for (std::size_t k = 1; k + 1 < variable.catalogue.size(); ++k) ends.push_back(static_cast<double>(k));
      std::set<std::string> reported;
      for (const double end : ends) {
        OptimizePoint point = start;
        point[i] = end;
        std::vector<Setting> settings = make_settings(problem_, point);
        std::erase_if(settings, [&](const Setting& setting) {
          return std::ranges::find(variable.paths, setting.path) == variable.paths.end();
        });
        const auto mistake = find_mistake(settings);
        if (mistake && reported.insert(mistake->what).second)
          mistakes_.add(
              variable.mark,
              "'" + variable.name + "' at " + write_value(variable, end) + " makes no valid scenario: " + mistake->what,
              mistake->mend);
      }
    }
    if (mistakes_.count() != before || problem_.variables.empty()) return;
    if (const auto mistake = find_mistake(make_settings(problem_, start)))
      mistakes_.add(problem_.variables.front().mark,
                    "the variables at their start make no valid scenario: " + mistake->what, mistake->mend);
  }

  [[nodiscard]] std::optional<ScenarioMistake> find_mistake(const std::vector<Setting>& settings) const {
    try {
      (void)problem_.tree->read(settings);
      return std::nullopt;
    } catch (const ScenarioError& error) {
      return error.mistakes.front();
    }
  }

  // Checks that the campaign's scenario has the paths of the variables, too.
  void check_campaign() {
    if (!problem_.campaign || mistakes_.count() != 0) return;
    try {
      (void)make_campaign(*problem_.campaign, make_settings(problem_, get_start(problem_)),
                          {problem_.campaign->samples});
    } catch (const ScenarioError& error) {
      mistakes_.add(problem_.variables.front().mark,
                    "the campaign, with the variables at their start: " + error.mistakes.front().what,
                    error.mistakes.front().mend);
    }
  }

  OptimizeProblem& problem_;
  const std::string folder_;
  Mistakes& mistakes_;
  bool campaign_reported_ = false, variables_sound_ = false;
};

}  // namespace

bool is_optimize_problem(const std::string& text) {
  if (text.find(kKey) == std::string::npos) return false;
  try {
    const YamlNode root = parse_yaml(text);
    return root.is_mapping() && root.find(kKey) != nullptr && root.find("unlatch") == nullptr;
  } catch (const YamlError&) {
    return false;
  }
}

OptimizeProblem load_optimize_problem_text(const std::string& text, const std::string& file,
                                           const std::string& folder) {
  OptimizeProblem problem;
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

OptimizeProblem load_optimize_problem(const std::string& path) {
  return load_optimize_problem_text(read_text_file(path, "optimisation problem"), path,
                                    std::filesystem::path(path).parent_path().string());
}

}  // namespace unlatch::hil
