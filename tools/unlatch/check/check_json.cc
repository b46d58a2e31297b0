#include "tools/unlatch/check/check_json.h"

#include <nlohmann/json.hpp>

#include "hil/run/findings/findings.h"
#include "hil/run/starting_quantities.h"
#include "tools/common/output.h"
#include "tools/common/text.h"
#include "tools/unlatch/check/check_findings.h"
#include "tools/unlatch/options/scenario_notes.h"
#include "tools/unlatch/results/finding_report.h"
#include "tools/unlatch/results/redundancy.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

Json build_body(const Body& body) {
  Json inertia = Json::array();
  for (int row = 0; row < 3; ++row) {
    inertia.push_back({body.inertia(row, 0), body.inertia(row, 1), body.inertia(row, 2)});
  }
  return {{"name", body.name}, {"mass", body.mass}, {"inertia", inertia}};
}

Json build_joint(const Model& model, const Joint& joint) {
  Json modes = Json::object();
  for (const JointMode& mode : joint.modes) {
    Json rows = Json::array();
    for (int row = 0; row < kRows; ++row) {
      if (has_row(mode.rows, row)) rows.push_back(kRowNames[row]);
    }
    modes[mode.name] = rows;
  }
  return {{"name", joint.name},
          {"between", {get_body_name(model, joint.base), get_body_name(model, joint.follower)}},
          {"mode", joint.modes[static_cast<std::size_t>(joint.mode)].name},
          {"modes", modes}};
}

// Leaves to root, as the factorisation goes.
Json build_elimination(const Model& model, const Plan& plan) {
  Json order = Json::array();
  const std::span<const TreeNode> tree = plan.get_tree();
  for (auto node = tree.rbegin(); node != tree.rend(); ++node) {
    Json entry = {{"body", get_body_name(model, node->body)}};
    if (node->joint != kNone) entry["joint"] = model.joints[static_cast<std::size_t>(node->joint)].name;
    if (node->parent != kNone) {
      entry["into"] = get_body_name(model, tree[static_cast<std::size_t>(node->parent)].body);
    }
    order.push_back(entry);
  }
  return order;
}

}  // namespace

void write_plan_json(const hil::Scenario& scenario, hil::Simulation& simulation,
                     const std::vector<RedundantRows>& redundant, const PlanJsonParts& parts,
                     const std::string& target) {
  const Model& model = scenario.model;
  const Plan& plan = simulation.plan();
  Json json = {{"schema", 1},
               {"valid", true},
               {"scenario", scenario.name},
               {"title", scenario.title},
               {"dt", scenario.dt},
               {"until", scenario.until},
               {"model_hash", to_hex(simulation.get_model_hash())}};
  json["bodies"] = Json::array();
  for (const Body& body : model.bodies) json["bodies"].push_back(build_body(body));
  json["joints"] = Json::array();
  for (const Joint& joint : model.joints) json["joints"].push_back(build_joint(model, joint));
  json["elimination"] = build_elimination(model, plan);
  json["loops"] = Json::array();
  for (const std::int32_t loop : plan.get_loops())
    json["loops"].push_back(model.joints[static_cast<std::size_t>(loop)].name);
  const LoopOverlap overlap = plan.get_loop_overlap();
  const LoopCost cost = calc_loop_cost(plan);
  json["loop_overlap"] = {{"loops", overlap.loops}, {"clusters", cost.clusters}, {"widest", overlap.widest},
                          {"local", overlap.local}, {"cost", cost.loops},        {"cost_of_tree", cost.tree}};
  json["redundant"] = Json::array();
  for (const RedundantRows& rows : redundant) json["redundant"].push_back(build_json(model, rows));
  json["elements"] = Json::array();
  for (const hil::SpringResolution& spring : hil::calc_resolutions(simulation)) {
    const double h = plan.get_options().dt, worst = h * spring.get_worst();
    json["elements"].push_back({{"name", model.element_name(spring.element)},
                                {"h_omega", h * spring.largest_omega},
                                {"h_decay", h * spring.largest_decay},
                                {"modes", spring.where},
                                {"h_omega_at_start", h * spring.omega},
                                {"h_decay_at_start", h * spring.decay},
                                {"implicit", spring.implicit},
                                {"stable", spring.implicit || worst <= kStable}});
  }
  json["requirements"] = build_requirement_checks(scenario);
  json["springs"] = build_springs_json(hil::list_springs(scenario));
  json["warnings"] = build_findings_json(scenario, hil::list_findings(scenario, simulation));
  json["counts"] = {{"channels", model.channels.size()},
                    {"sensor_values", plan.get_sensor_count()},
                    {"signals", model.signals.size()},
                    {"events", model.events.size()}};
  json["notes"] = list_notes(scenario);
  if (!parts.cost.target.empty()) json["cost"] = build_cost_json(scenario, plan, parts.cost);
  if (parts.quantities) {
    json["quantities"] = Json::array();
    for (const hil::StartingQuantity& quantity : hil::list_starting_quantities(scenario))
      json["quantities"].push_back(
          {{"name", quantity.name}, {"text", quantity.text}, {"unit", quantity.unit}, {"value", quantity.value}});
  }
  json["bytes"] = {{"state", plan.get_state_bytes()}, {"workspace", plan.get_workspace_bytes()}};
  write_json(json, target);
}

void write_mistakes_json(const hil::ScenarioError& error, const std::string& target) {
  Json json = {{"schema", 1}, {"valid", false}, {"mistakes", Json::array()}};
  for (const hil::ScenarioMistake& mistake : error.mistakes) {
    json["mistakes"].push_back({{"file", mistake.file},
                                {"line", mistake.mark.line},
                                {"column", mistake.mark.column},
                                {"override", mistake.override_text},
                                {"what", mistake.what},
                                {"mend", mistake.mend}});
  }
  write_json(json, target);
}

}  // namespace unlatch::tools
