// Options of the scenario: its path, and values that replace its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {

struct ScenarioOptions {
  std::string path;
  std::vector<std::string> overrides;
  double until = 0, dt = 0;  // s; 0: as the scenario says
};
void add_scenario_options(Command command, ScenarioOptions& options);

// Throws hil::ScenarioError.
hil::Scenario load(const ScenarioOptions& options);
std::int64_t calc_last_tick(const hil::Scenario& scenario);

}  // namespace unlatch::tools
