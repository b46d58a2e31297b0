#include "tools/unlatch/options/scenario_options.h"

#include <cmath>
#include <cstdio>

#include "hil/run/run.h"
#include "hil/study/optimize/problem/problem.h"
#include "tools/common/text.h"
#include "tools/unlatch/options/scenario_notes.h"

namespace unlatch::tools {
namespace {

constexpr double kSameTime = 1e-6;  // of a step

// All digits: what is read back is what was typed.
std::string to_text(double value) { return format("%.17g", value); }

void refuse_optimize_problem(const std::string& path) {
  if (hil::is_standard_input(path) || !hil::is_optimize_problem(hil::read_text_file(path, "scenario"))) return;
  throw hil::ScenarioError({{.file = path,
                             .mark = {},
                             .override_text = "",
                             .what = "this is an optimisation problem, not a scenario",
                             .mend = "`unlatch optimize` looks for its values, and its DIR/patch.yaml runs"}});
}

}  // namespace

void add_scenario_options(Command command, ScenarioOptions& options) {
  command.add_option("SCENARIO", options.path, "scenario file (.yaml); - for standard input").required();
  command.add_option("--until", options.until, "end of the run, s or with its unit (default: the scenario's)")
      .type_name("SECONDS")
      .seconds();
  command.add_option("--dt", options.dt, "step, s (default: the scenario's)").type_name("SECONDS").seconds();
  command
      .add_option("--set", options.overrides,
                  "replaces one value of the scenario, for example bodies.core.mass=98000; repeatable")
      .type_name("PATH=VALUE")
      .repeatable();
}

hil::Scenario load(const ScenarioOptions& options) {
  refuse_optimize_problem(options.path);
  std::vector<std::string> overrides = options.overrides;
  if (options.dt > 0) overrides.push_back("step.dt=" + to_text(options.dt));
  if (options.until > 0) overrides.push_back("step.until=" + to_text(options.until));
  hil::Scenario scenario = hil::load_scenario(options.path, overrides);
  const double end = static_cast<double>(calc_last_tick(scenario)) * scenario.dt;
  if (std::abs(end - scenario.until) > kSameTime * scenario.dt) {
    std::fprintf(stderr, "note: %.9g s is not on a tick; the run ends at %.9g s\n", scenario.until, end);
  }
  if (options.until > 0) return scenario;  // an end before some events is wanted
  for (const std::string& note : list_notes(scenario)) std::fprintf(stderr, "note: %s\n", note.c_str());
  return scenario;
}

std::int64_t calc_last_tick(const hil::Scenario& scenario) {
  return hil::calc_nearest_tick(scenario.until, scenario.dt);
}

}  // namespace unlatch::tools
