// The subcommands of `unlatch`. Each adds itself to the command line; the program then runs the chosen one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hil/notices/resolution.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"
#include "tools/command_line.h"

namespace unlatch::tools {

// Each sets `exit_code` when it has run. Errors of the user's files, the middleware and so on leave as exceptions;
// main.cc turns them into messages and exit codes.
void add_check(Command app, int& exit_code);
void add_run(Command app, int& exit_code);
void add_campaign(Command app, int& exit_code);
void add_hil(Command app, int& exit_code);
void add_replay(Command app, int& exit_code);
void add_preflight(Command app, int& exit_code);
void add_diff(Command app, int& exit_code);
void add_report(Command app, int& exit_code);
void add_log(Command app, int& exit_code);
void add_init(Command app, int& exit_code);
void add_optimize(Command app, int& exit_code);
void add_modes(Command app, int& exit_code);
void add_export(Command app, int& exit_code);
void add_import(Command app, int& exit_code);
void add_watch(Command app, int& exit_code);
void add_completion(Command app, int& exit_code);
void add_man(Command app, int& exit_code);

struct ScenarioOptions {
  std::string path;
  std::vector<std::string> overrides;
  double until = 0, dt = 0;  // s; 0: as the scenario says
};
void add_scenario_options(Command command, ScenarioOptions& options);

// If the path is a campaign's, that is replaced by its scenario with the values of one sample: those of the campaign,
// or of its folder of results, if one is named. Throws hil::ScenarioError.
void choose_sample(ScenarioOptions& options, std::int64_t sample, const std::string& results);
// The path is a campaign file's.
bool is_campaign(const ScenarioOptions& options);

// Throws hil::ScenarioError.
hil::Scenario load(const ScenarioOptions& options);
// Parts of a valid scenario that cannot come true: an event whose time is after the end.
std::vector<std::string> list_notes(const hil::Scenario& scenario);
std::int64_t calc_last_tick(const hil::Scenario& scenario);

// Says on standard error which springs the step cannot integrate stably; `check` shows all of them.
void warn_of_unstable_elements(const hil::Scenario& scenario);

using hil::kAccurate, hil::kStable;

// The outputs that run and hil may write; a recording is a file, and another one than the JSON's.
struct OutputOptions {
  std::string json, log, junit;
};
void add_output_options(Command command, OutputOptions& options);
void add_junit_option(Command command, std::string& junit);
// --outputs. `text`: empty for those of the scenario.
void add_outputs_option(Command command, std::string& text);
// The groups of --outputs, else the scenario's. Refuses names that are none.
std::vector<hil::OutputGroup> choose_outputs(const hil::Scenario& scenario, const std::string& text);

}  // namespace unlatch::tools
