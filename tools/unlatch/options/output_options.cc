#include "tools/unlatch/options/output_options.h"

namespace unlatch::tools {

void add_junit_option(Command command, std::string& junit) {
  command.add_option("--junit", junit, "the requirements as test cases, JUnit XML").type_name("FILE");
}

void add_output_options(Command command, OutputOptions& options) {
  command.add_json_option(options.json);
  add_junit_option(command, options.junit);
  command.add_option("--log", options.log, "recording to write (LCM event log), for `unlatch replay`")
      .type_name("FILE");
  command.parsed_callback([&options] {
    if (options.log == "-") refuse_option("--log", "a recording goes to a file, not to standard output");
    if (!options.log.empty() && options.log == options.json)
      refuse_option("--log", "the recording and the JSON need different files");
  });
}

void add_outputs_option(Command command, std::string& text) {
  command
      .add_option("--outputs", text,
                  "outputs to write, by patterns of their names (`unlatch check SCENARIO --outputs` lists them), each "
                  "with the ticks from one row to the next or a rate: 'core.*,*.force@10,sensor.*@100Hz' (default: "
                  "those of the scenario)")
      .type_name("PATTERN,...");
}

std::vector<hil::OutputGroup> choose_outputs(const hil::Scenario& scenario, const std::string& text,
                                             hil::SensorsShown shown) {
  if (text.empty()) return scenario.outputs;
  try {
    return hil::parse_outputs(text, scenario.dt, hil::list_outputs(scenario, shown));
  } catch (const std::invalid_argument& error) {
    refuse_option("--outputs", error.what());
  }
}

}  // namespace unlatch::tools
