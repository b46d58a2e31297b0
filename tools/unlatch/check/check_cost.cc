#include "tools/unlatch/check/check_cost.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/common/terminal.h"
#include "tools/common/text.h"

namespace unlatch::tools {
namespace {

// A kind of step, and the most that it costs.
struct BoundedStep {
  const char* key;   // of JSON
  const char* text;  // for people
  StepLimits limits;
  StepCost cost;
};

std::vector<BoundedStep> list_steps(const Plan& plan, const CostTarget& target) {
  std::vector<BoundedStep> steps;
  const auto add = [&](const char* key, const char* text, const StepLimits& limits) {
    steps.push_back({key, text, limits, calc_step_cost(plan, target, limits)});
  };
  const StepLimits most = calc_step_limits(plan);
  StepLimits smooth;
  smooth.follows = true;
  add("smooth", "a step without events, after another one", smooth);
  if (most.parts > 1) {
    smooth.parts = smooth.sub_steps = smooth.tries = most.parts;
    add("contacts", "with a closed contact, in all its parts", smooth);
  }
  add("most", "all limits reached", most);
  return steps;
}

double to_microseconds(const CostOptions& options, double instructions) {
  return instructions * options.cycles / options.clock;
}

std::string join(const std::vector<std::string>& list) {
  std::string text;
  for (const std::string& one : list) text += (text.empty() ? "" : ", ") + one;
  return text;
}

void print_limits(const StepLimits& limits) {
  const auto number = [](std::int64_t n, const char* noun) { return count(static_cast<std::size_t>(n), noun); };
  std::printf("  at most %s with a closed contact, %s at events, %s, %s in all, %s of events\n",
              number(limits.parts, "part").c_str(), number(limits.splits, "split").c_str(),
              number(limits.searches, "try").c_str(), number(limits.tries, "integration").c_str(),
              number(limits.rounds, "round").c_str());
}

void print_rows(const BoundedStep& step) {
  std::printf("  %-34s %8s %12s %12s %12s %12s %14s\n", "instructions at the limits", "calls", "bodies", "forces",
              "solver", "rest", "all");
  for (const CostRow& row : step.cost.rows)
    std::printf("  %-34s %8.0f %12.0f %12.0f %12.0f %12.0f %14.0f\n", row.phase, row.calls, row.bodies, row.forces,
                row.solver, row.rest, row.total());
}

}  // namespace

std::vector<std::string> list_cost_target_names() {
  std::vector<std::string> names;
  for (const CostTarget* target : list_cost_targets()) names.emplace_back(target->name);
  return names;
}

void print_cost(const hil::Scenario& scenario, const Plan& plan, const CostOptions& options) {
  const CostTarget& target = *find_cost_target(options.target);
  const std::vector<BoundedStep> steps = list_steps(plan, target);
  print_heading(stdout, format("Most that a step costs on %s (%s)", target.name, target.processor));
  const std::vector<std::string>& unmeasured = steps.back().cost.unmeasured;
  if (!unmeasured.empty()) {
    std::printf("  no bound: not measured on this target: %s. Measure them with tools/cost\n",
                join(unmeasured).c_str());
    return;
  }
  print_limits(steps.back().limits);
  print_rows(steps.back());
  for (const BoundedStep& step : steps) {
    std::printf("  %-42s %14.0f instructions, %.0f cycles at %g each", step.text, step.cost.instructions,
                step.cost.instructions * options.cycles, options.cycles);
    if (options.clock > 0) {
      const double time = to_microseconds(options, step.cost.instructions);
      std::printf(", %.1f us at %g MHz, %.3g of a step of %g s", time, options.clock, 1e-6 * time / scenario.dt,
                  scenario.dt);
    }
    std::printf("\n");
  }
  if (options.clock > 0 && scenario.timing.watchdog > 0)
    std::printf("  the watchdog acts after %g s: %.3g times the longest step\n", scenario.timing.watchdog,
                scenario.timing.watchdog / (1e-6 * to_microseconds(options, steps.back().cost.instructions)));
}

nlohmann::ordered_json build_cost_json(const hil::Scenario& scenario, const Plan& plan, const CostOptions& options) {
  using Json = nlohmann::ordered_json;
  const CostTarget& target = *find_cost_target(options.target);
  const std::vector<BoundedStep> steps = list_steps(plan, target);
  const BoundedStep& most = steps.back();
  Json json = {{"target", target.name}, {"processor", target.processor}, {"unmeasured", most.cost.unmeasured}};
  json["limits"] = {{"parts", most.limits.parts},         {"splits", most.limits.splits},
                    {"sub_steps", most.limits.sub_steps}, {"tries", most.limits.searches},
                    {"integrations", most.limits.tries},  {"rounds", most.limits.rounds},
                    {"waits", most.limits.waits},         {"jumps", most.limits.jumps}};
  if (!most.cost.unmeasured.empty()) return json;
  json["phases"] = Json::array();
  for (const CostRow& row : most.cost.rows)
    json["phases"].push_back({{"phase", row.phase},
                              {"calls", row.calls},
                              {"bodies", row.bodies},
                              {"forces", row.forces},
                              {"solver", row.solver},
                              {"rest", row.rest},
                              {"instructions", row.total()}});
  json["cycles_per_instruction"] = options.cycles;
  for (const BoundedStep& step : steps) {
    Json& own = json[step.key] = {{"instructions", step.cost.instructions},
                                  {"cycles", step.cost.instructions * options.cycles}};
    if (options.clock > 0) own["time"] = 1e-6 * to_microseconds(options, step.cost.instructions);
  }
  json["dt"] = scenario.dt;
  json["watchdog"] = scenario.timing.watchdog;
  return json;
}

}  // namespace unlatch::tools
