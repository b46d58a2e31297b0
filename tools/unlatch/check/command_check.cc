// unlatch check: validates a scenario and prints its plan.
#include <cmath>
#include <cstdarg>
#include <nlohmann/json.hpp>

#include "bridge/telemetry/session_layout.h"
#include "bridge/telemetry/xtce.h"
#include "hil/run/findings/findings.h"
#include "hil/run/run.h"
#include "hil/run/starting_quantities.h"
#include "hil/scenario/base/philox.h"
#include "hil/session/participants/announcer.h"
#include "hil/study/campaign/campaign.h"
#include "hil/study/campaign/campaign_findings.h"
#include "hil/study/optimize/problem/problem_findings.h"
#include "tools/common/alike.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/check/check_cost.h"
#include "tools/unlatch/check/check_findings.h"
#include "tools/unlatch/check/check_json.h"
#include "tools/unlatch/check/graph.h"
#include "tools/unlatch/check/verbs.h"
#include "tools/unlatch/options/campaign_sample.h"
#include "tools/unlatch/options/scenario_notes.h"
#include "tools/unlatch/options/scenario_options.h"
#include "tools/unlatch/results/finding_report.h"
#include "tools/unlatch/results/redundancy.h"
#include "tools/unlatch/studies/optimize_report.h"
#include "unlatch/redundancy.h"

namespace unlatch::tools {
namespace {

void print_bodies(const Model& model) {
  print_heading(stdout, "Bodies");
  FoldedList list;
  for (const Body& body : model.bodies) {
    list.add(body.name, format("mass %.6g kg, inertia %.6g %.6g %.6g kg m2", body.mass, body.inertia(0, 0),
                               body.inertia(1, 1), body.inertia(2, 2)));
  }
  list.print(stdout, 16);
}

void print_joints(const Model& model) {
  if (model.joints.empty()) return;
  print_heading(stdout, "Joints, their modes and rows (* initial)");
  FoldedList list;
  for (const Joint& joint : model.joints) {
    std::string text = ": " + FoldedList::mark(get_body_name(model, joint.base)) + " – " +
                       FoldedList::mark(get_body_name(model, joint.follower));
    for (std::size_t mode = 0; mode < joint.modes.size(); ++mode) {
      const int count = __builtin_popcount(joint.modes[mode].rows);
      text += format("\n    %c %-14s %d %s: %s", static_cast<int>(mode) == joint.mode ? '*' : ' ',
                     joint.modes[mode].name.c_str(), count, count == 1 ? "row" : "rows",
                     list_rows(joint.modes[mode].rows, "none").c_str());
    }
    list.add(joint.name, text);
  }
  list.print(stdout);
}

// How the loops lie beside each other, and what they are estimated to cost.
void print_loop_cost(const Plan& plan) {
  const LoopOverlap overlap = plan.get_loop_overlap();
  if (overlap.loops == 0) return;
  const LoopCost cost = calc_loop_cost(plan);
  const std::string loops = count(static_cast<std::size_t>(overlap.loops), "loop"),
                    clusters = count(static_cast<std::size_t>(cost.clusters), "cluster");
  if (overlap.local)
    std::printf("  %s in %s, each eliminated where it closes; at most %d are open at one body\n", loops.c_str(),
                clusters.c_str(), overlap.widest);
  else if (overlap.loops > 1)
    std::printf("  %s, eliminated together by one dense matrix: a flexible body is on the way of one\n", loops.c_str());
  constexpr double kASubstep = 5;  // factorisations and solutions
  std::printf("  estimated: %.2g million multiplications a step for loops, %.2g million for the rest of the solver\n",
              1e-6 * kASubstep * static_cast<double>(cost.loops), 1e-6 * kASubstep * static_cast<double>(cost.tree));
}

// Leaves to root, as the factorisation goes: the reverse of the plan's nodes.
void print_elimination(const Model& model, const Plan& plan) {
  print_heading(stdout, "Elimination order, leaves to root");
  const std::span<const TreeNode> tree = plan.get_tree();
  FoldedList list;
  for (auto node = tree.rbegin(); node != tree.rend(); ++node) {
    const std::string& body = model.bodies[static_cast<std::size_t>(node->body)].name;
    const std::string joint =
        node->joint == kNone ? "" : FoldedList::mark(model.joints[static_cast<std::size_t>(node->joint)].name);
    if (node->parent != kNone) {
      const auto& parent = tree[static_cast<std::size_t>(node->parent)];
      const std::string through =  // a flexible body and its markers have no joint between them
          joint.empty() ? "" : "through " + joint + " ";
      list.add(body, through + "into " + FoldedList::mark(model.bodies[static_cast<std::size_t>(parent.body)].name));
    } else {
      list.add(body, joint.empty() ? "root" : "root, held to the ground by " + joint);
    }
  }
  list.print(stdout, 16);
  FoldedList loops;
  for (const std::int32_t loop : plan.get_loops())
    loops.add(model.joints[static_cast<std::size_t>(loop)].name, "closes a loop");
  loops.print(stdout, 0);
  print_loop_cost(plan);
}

void print_redundant(const Model& model, const std::vector<RedundantRows>& redundant) {
  if (redundant.empty()) return;
  print_heading(stdout, "Redundant rows at the start");
  for (const RedundantRows& rows : redundant) std::printf("  %s\n", describe(model, rows).c_str());
}

// The first three items of a list in words; the JSON has all.
std::string shorten(const std::string& list) {
  std::size_t end = 0, more = 0;
  for (std::size_t comma = list.find(", "), k = 1; comma != std::string::npos;
       comma = list.find(", ", comma + 2), ++k) {
    if (k == 3) end = comma;
    if (k >= 3) ++more;
  }
  return end == 0 ? list : list.substr(0, end) + " and " + std::to_string(more) + " more";
}

void print_elements(const Model& model, const hil::Simulation& simulation) {
  const Plan& plan = simulation.plan();
  const std::vector<hil::SpringResolution> springs = hil::calc_resolutions(simulation);
  if (springs.empty()) return;
  print_heading(stdout, "Elastic elements, h = step; the largest of all modes that events can set");
  FoldedList list;
  for (const hil::SpringResolution& spring : springs) {
    const double h_omega = plan.get_options().dt * spring.largest_omega;
    const double h_decay = plan.get_options().dt * spring.largest_decay;
    const double worst = std::max(h_omega, h_decay);
    std::string verdict = "resolved";
    if (spring.implicit)
      verdict = worst > kAccurate ? "implicit: second order, damps what the step does not resolve" : "implicit";
    else if (worst > kStable)
      verdict = paint(stdout, Colour::kRed, "unstable: make the step smaller, or the element softer");
    else if (worst > kAccurate)
      verdict = paint(stdout, Colour::kYellow, "stable, but not resolved accurately");
    const std::string where = spring.where.empty() ? "" : " (with " + shorten(spring.where) + ")";
    list.add(model.element_name(spring.element),
             format("h*omega %-10.4g h*decay %-10.4g ", h_omega, h_decay) + verdict + where);
  }
  list.print(stdout, 20);
}

void print_plan(const hil::Scenario& scenario, hil::Simulation& simulation,
                const std::vector<RedundantRows>& redundant) {
  const Plan& plan = simulation.plan();
  std::printf("%s: %s\n", paint(stdout, Colour::kBold, scenario.name).c_str(), scenario.title.c_str());
  std::printf(
      "  step %g s, %s to %g s; %s, %s, %s, %s\n", scenario.dt,
      count(static_cast<std::size_t>(calc_last_tick(scenario)), "tick").c_str(), scenario.until,
      count(scenario.model.channels.size(), "channel").c_str(), count(plan.get_sensor_count(), "sensor value").c_str(),
      count(scenario.model.signals.size(), "signal").c_str(), count(scenario.model.events.size(), "event").c_str());
  print_bodies(scenario.model);
  print_joints(scenario.model);
  print_elimination(scenario.model, plan);
  print_redundant(scenario.model, redundant);
  print_elements(scenario.model, simulation);
  print_requirement_checks(scenario);
  print_springs(stdout, hil::list_springs(scenario));
  print_findings(stdout, scenario, hil::list_findings(scenario, simulation));
  print_heading(stdout, "Memory");
  std::printf("  state %s, workspace %s\n", count(plan.get_state_bytes(), "byte").c_str(),
              count(plan.get_workspace_bytes(), "byte").c_str());
  std::printf("\nmodel hash %s\n", to_hex(simulation.get_model_hash()).c_str());
  std::printf("\n%s\n", paint(stdout, Colour::kGreen, scenario.file + " is valid").c_str());
}

constexpr const char* kDrawn = "what may be drawn";

// Warnings of the scenario, and those at the corners of what may be chosen: "what may be drawn" or "the bounds".
nlohmann::ordered_json print_corner_findings(std::FILE* to, const std::vector<hil::CampaignFinding>& findings,
                                             const char* chosen) {
  nlohmann::ordered_json warnings = nlohmann::ordered_json::array();
  for (const hil::CampaignFinding& one : findings) {
    if (warnings.empty()) std::fprintf(to, "Warnings of the scenario\n");
    const std::string corners =
        one.corners == 0 ? "" : format(" (at %d of %d corners of %s)", one.corners, hil::kFindingCorners, chosen);
    const std::string text = one.finding.where + (one.finding.where.empty() ? "" : " ") + one.finding.text + corners;
    std::fprintf(to, "  %s\n", paint(to, Colour::kYellow, text).c_str());
    warnings.push_back({{"name", one.finding.name},
                        {"where", one.finding.where},
                        {"text", one.finding.text},
                        {"corners", one.corners}});
  }
  return warnings;
}

// Parameters with their paths and quantiles; what may be drawn has been tried.
int check_campaign(const ScenarioOptions& options, const std::string& json) {
  const hil::Campaign campaign = hil::load_campaign(options.path, options.overrides);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::FILE* const to = get_people_stream(json);
  std::fprintf(to, "%s: %s%s, %s, seed %llu, of %s\n", campaign.name.c_str(), campaign.failure ? "at most " : "",
               count(campaign.plan.samples, "sample").c_str(),
               hil::kSamplingNames[static_cast<std::size_t>(campaign.plan.sampling)].c_str(),
               static_cast<unsigned long long>(campaign.plan.seed), campaign.scenario.c_str());
  if (campaign.failure)
    std::fprintf(to, "  of %s %s %s %s; levels of %s, at most %d, %s\n", campaign.failure->column.c_str(),
                 campaign.failure->above ? "above" : "below", hil::to_text(campaign.failure->limit).c_str(),
                 campaign.failure->unit.c_str(), count(campaign.failure->samples, "sample").c_str(),
                 campaign.failure->levels, count(campaign.failure->chains, "chain").c_str());
  if (const std::size_t columns = campaign.chosen.count(); columns > 0)
    std::fprintf(to, "  outputs and curves: %s of the results\n", count(columns, "column").c_str());
  for (const std::string& remark : campaign.remarks)
    std::fprintf(to, "%s\n", paint(to, Colour::kYellow, "note: " + remark).c_str());
  if (campaign.plan.sampling != hil::Sampling::kCsv)
    std::fprintf(to, "  %-24s %12s %12s %12s\n", "", "least", "median", "greatest");
  for (const hil::CampaignParameter& parameter : campaign.parameters) {
    std::string paths;
    for (const std::string& path : parameter.paths) paths += (paths.empty() ? "" : ", ") + path;
    const auto at = [&](double p) { return parameter.distribution.calc_quantile(p); };
    const double tail = hil::kLeastUnit;  // what the generator can give
    const char* const unit = parameter.distribution.is_cone() ? "rad from its axis" : parameter.unit.c_str();
    if (parameter.drawn)
      std::fprintf(to, "  %-24s %12.6g %12.6g %12.6g %s: %s\n", parameter.name.c_str(), at(tail), at(0.5), at(1 - tail),
                   unit, paths.c_str());
    else
      std::fprintf(to, "  %-24s from the table: %s\n", parameter.name.c_str(), paths.c_str());
    list.push_back({{"name", parameter.name}, {"paths", parameter.paths}, {"unit", parameter.unit}});
  }
  const nlohmann::ordered_json warnings = print_corner_findings(to, hil::list_campaign_findings(campaign), kDrawn);
  std::fprintf(to, "%s is valid\n", campaign.file.c_str());
  if (!json.empty())
    write_json(nlohmann::ordered_json{{"schema", 1},
                                      {"campaign", campaign.name},
                                      {"samples", campaign.plan.samples},
                                      {"parameters", list},
                                      {"chosen_columns", campaign.chosen.count()},
                                      {"remarks", campaign.remarks},
                                      {"warnings", warnings}},
               json);
  return kExitDone;
}

// With JSON on standard output the text is left out.
void print_outputs(const hil::Scenario& scenario) {
  std::printf("%-44s %-11s %s\n", "outputs", "frame", "columns");
  for (const hil::Output& output : hil::list_outputs(scenario)) {
    std::printf("  %-42s %-11s", output.name.c_str(), output.frame.c_str());
    for (const hil::Output::Column& column : output.columns)
      std::printf(" %s [%s]", column.name.c_str(), column.unit.c_str());
    std::printf("\n");
  }
}

// Quantities that the scenario names, and those that it may name: unit, value at the start, the text to write.
void print_quantities(const hil::Scenario& scenario) {
  const std::vector<hil::StartingQuantity> list = hil::list_starting_quantities(scenario);
  std::printf("%-24s %14s %-7s %s\n", "quantities", "at the start", "unit", "text");
  for (const hil::StartingQuantity& quantity : list)
    std::printf("  %-22s %14.6g %-7s %s\n", quantity.name.c_str(), quantity.value, quantity.unit.c_str(),
                quantity.text.c_str());
}

// The packets that telemetry makes of a session of the scenario.
std::string describe_packets(const hil::Scenario& scenario, const hil::Simulation& simulation) {
  hil::SessionOptions options;
  options.session = 1;  // no packet's description depends on it
  options.flight_software = scenario.flight_software;
  const std::vector<hil::CatalogMessage> catalog = hil::build_session_catalog(simulation, options);
  bridge::SessionLayout layout;
  layout.hear(hil::build_hello(simulation, scenario.name, options, catalog));
  for (const hil::CatalogMessage& item : catalog) layout.hear(item);
  layout.take_modes(scenario.model);
  return bridge::write_xtce(layout);
}

// What `check` appends to the plan, and writes beside it.
struct Lists {
  bool outputs = false, quantities = false;
  std::string xtce;
  CostOptions cost;
};

int run(const ScenarioOptions& options, const std::string& graph, const std::string& json, const Lists& lists) {
  check_output(json);
  check_output(lists.xtce);
  try {
    if (is_campaign(options)) return check_campaign(options, json);
    if (!hil::is_standard_input(options.path) &&
        hil::is_optimize_problem(hil::read_text_file(options.path, "scenario"))) {
      const hil::OptimizeProblem problem = hil::load_optimize_problem(options.path);
      print_problem(get_people_stream(json), problem);
      std::FILE* const to = get_people_stream(json);
      nlohmann::ordered_json warnings = print_corner_findings(to, hil::list_problem_findings(problem), "the bounds");
      if (problem.campaign)
        for (const nlohmann::ordered_json& one :
             print_corner_findings(to, hil::list_campaign_findings(*problem.campaign->nominal), kDrawn))
          warnings.push_back(one);
      if (!json.empty()) write_problem_json(problem, warnings, json);
      return kExitDone;
    }
    const hil::Scenario scenario = load(options);
    const auto simulation = hil::build_simulation(scenario);
    if (!graph.empty()) {
      const std::string& title = scenario.title.empty() ? scenario.name : scenario.title;
      draw_graph(describe_graph(scenario.model, simulation->plan(), title), graph);
    }
    const std::vector<RedundantRows> redundant =
        list_redundant_rows(simulation->plan(), simulation->state(), simulation->workspace());
    if (json != "-") print_plan(scenario, *simulation, redundant);
    if (json != "-" && lists.outputs) print_outputs(scenario);
    if (json != "-" && lists.quantities) print_quantities(scenario);
    if (json != "-" && !lists.cost.target.empty()) print_cost(scenario, simulation->plan(), lists.cost);
    if (!lists.xtce.empty()) write_text(describe_packets(scenario, *simulation), lists.xtce);
    if (!json.empty()) write_plan_json(scenario, *simulation, redundant, {lists.quantities, lists.cost}, json);
  } catch (const hil::ScenarioError& error) {
    if (!json.empty()) write_mistakes_json(error, json);
    throw;
  }
  return kExitDone;
}

}  // namespace

void add_check(Command app, int& exit_code) {
  auto options = std::make_shared<ScenarioOptions>();
  auto graph = std::make_shared<std::string>();
  auto lists = std::make_shared<Lists>();
  auto json = std::make_shared<std::string>();
  Command command =
      app.add_verb("check", "Validates a scenario and prints its plan, or every mistake with file, line and column.",
                   "unlatch check hil/scenarios/boosters/scenario.yaml --graph boosters.svg");
  add_scenario_options(command, *options);
  command.add_option("--graph", *graph, "drawing of bodies, joints, modes and events (.svg); needs graphviz")
      .type_name("FILE");
  command
      .add_option("--xtce", lists->xtce,
                  "XTCE description of the packets that `unlatch telemetry` makes of a session, with names of modes")
      .type_name("FILE");
  command.add_flag("--outputs", lists->outputs, "lists what runs can write: names, frames, columns, units");
  command.add_flag(
      "--quantities", lists->quantities,
      "lists quantities for conditions, sensors, requirements and outputs: unit, value at the start, text");
  command
      .add_option("--cost", lists->cost.target,
                  "the most that a step costs on this target: instructions by phase, from the plan alone")
      .type_name("TARGET")
      .one_of(list_cost_target_names());
  command
      .add_option("--cycles", lists->cost.cycles,
                  "--cost: cycles that the processor takes for an instruction, on average")
      .type_name("NUMBER")
      .positive()
      .default_shown();
  command.add_option("--clock", lists->cost.clock, "--cost: clock of the processor, for times")
      .type_name("MHZ")
      .positive();
  command.add_json_option(*json, "for an invalid scenario its mistakes");
  command.callback([options, graph, json, lists, &exit_code] { exit_code = run(*options, *graph, *json, *lists); });
}

}  // namespace unlatch::tools
