// unlatch replay: runs a recording again and says whether every bit agrees.
#include "tools/exit_codes.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/report.h"

namespace unlatch::tools {
namespace {

struct ReplayOptions {
  std::string log, json;
};

std::string describe_status(const hil::RecordingReader& recording, const hil::ReplayResult& result) {
  if (!result.agrees()) return "different";
  if (recording.damaged) return "damaged";
  if (!recording.end) return "truncated";
  return get_status_name(recording.end->status);
}

std::string describe_end(const hil::RecordingReader& recording, std::int64_t tick) {
  if (recording.end) return recording.end->message;
  return "the recording is not complete: " + recording.shortfall + "; replayed up to tick " + std::to_string(tick);
}

int run(const ReplayOptions& options) {
  hil::RecordingReader recording{hil::LogFileReader(options.log)};
  const hil::Scenario scenario = hil::load_recorded_scenario(recording.header);
  const auto simulated = hil::build_recorded_simulation(recording.header, scenario, options.log);
  hil::Simulation& simulation = *simulated;
  hil::RunAnalysis analysis(scenario, simulation, {recording.header.last_tick});
  const hil::ReplayResult result = hil::replay(recording, simulation, &analysis);

  const RunReport report{scenario,
                         simulation,
                         analysis,
                         describe_status(recording, result),
                         describe_end(recording, simulation.get_tick()),
                         simulation.get_tick(),
                         simulation.calc_hash(),
                         recording.end ? recording.end->timing : hil::TimingSummary{},
                         recording.notices,
                         result};
  print_report(get_people_stream(options.json), report);
  write_json(build_json(report), options.json);
  return result.agrees() && !recording.damaged ? kExitDone : kExitFailed;
}

}  // namespace

void add_replay(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command =
      app.add_subcommand("replay",
                         "Runs a recording again, compares the state's hash at every tick, and names the first "
                         "difference (exit code 1). A recording that was cut short replays up to its end, with status "
                         "'truncated' and exit code 0.\nExample: unlatch replay run.log --json -");
  command->add_option("LOG", options->log, "recording made by --log")->required();
  command->add_option("--json", options->json, "file for the result as JSON, or - for standard output");
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
