// Options of the outputs that a run writes.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/scenario.h"
#include "tools/program/command_line.h"

namespace unlatch::tools {

// The outputs that run and hil may write; a recording is a file, and another one than the JSON's.
struct OutputOptions {
  std::string json, log, junit;
};
void add_output_options(Command command, OutputOptions& options);
void add_junit_option(Command command, std::string& junit);
// --outputs. `text`: empty for those of the scenario.
void add_outputs_option(Command command, std::string& text);
// The groups of --outputs, else the scenario's. Refuses names that are none.
std::vector<hil::OutputGroup> choose_outputs(const hil::Scenario& scenario, const std::string& text,
                                             hil::SensorsShown shown = hil::SensorsShown::kAsScenario);

}  // namespace unlatch::tools
