#include <cmath>
#include <cstdio>

#include "tools/unlatch/commands.h"

namespace unlatch::tools {
namespace {

// All digits: what is read back is what was typed.
std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// CLI::PositiveNumber says so in four hundred digits.
std::string check_seconds(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
             ? std::string{}
             : "'" + text + "' is not a positive number of seconds";
}

}  // namespace

void add_scenario_options(CLI::App& command, ScenarioOptions& options) {
  command.add_option("SCENARIO", options.path, "scenario file (.yaml)")->required();
  command.add_option("--until", options.until, "end of the run, s")->check(check_seconds);
  command.add_option("--dt", options.dt, "step, s")->check(check_seconds);
  command
      .add_option("--set", options.overrides,
                  "PATH=VALUE: replaces one value of the scenario, e.g. bodies.core.mass=98000; repeatable")
      ->take_all()
      ->allow_extra_args(false);
}

hil::Scenario load(const ScenarioOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  if (options.dt > 0) overrides.push_back("step.dt=" + to_text(options.dt));
  if (options.until > 0) overrides.push_back("step.until=" + to_text(options.until));
  return hil::load_scenario(options.path, overrides);
}

std::int64_t calc_last_tick(const hil::Scenario& scenario) { return std::llround(scenario.until / scenario.dt); }

}  // namespace unlatch::tools
