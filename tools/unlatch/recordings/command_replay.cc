// unlatch replay: runs a recording again and says whether every bit agrees.
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/options/output_options.h"
#include "tools/unlatch/recordings/replayed_log.h"
#include "tools/unlatch/recordings/verbs.h"
#include "tools/unlatch/results/accuracy_report.h"
#include "tools/unlatch/results/report.h"
#include "tools/unlatch/results/verdict_report.h"

namespace unlatch::tools {
namespace {

struct ReplayOptions {
  std::string log, json, junit, outputs;
  std::int64_t hashes = 0;  // ticks between two; 0: none is printed
};

// NAME TICK HASH, as the programs for targets print them (kernel/TARGETS.md).
std::string list_hashes(const ReplayOptions& options, ReplayedLog& log, Progress& progress) {
  std::string lines;
  std::int64_t listed = 0;
  const hil::Simulation& simulation = *log.opened.simulation;
  const auto add = [&] {
    listed = simulation.get_tick();
    lines += log.opened.scenario.name + " " + std::to_string(listed) + " " + to_hex(simulation.calc_hash()) + "\n";
  };
  log.replay([&](const StepReport&) {
    progress.show(simulation.get_tick());
    if (options.hashes > 0 && simulation.get_tick() > 0 && simulation.get_tick() % options.hashes == 0) add();
  });
  if (options.hashes > 0 && simulation.get_tick() > listed) add();
  return lines;
}

int run(const ReplayOptions& options) {
  check_output(options.json);
  check_output(options.junit);
  const WallTime wall_time;
  ReplayedLog log(options.log, options.outputs);
  Progress progress(log.opened.recording.header.dt, log.opened.recording.header.last_tick);
  const std::string hashes = list_hashes(options, log, progress);
  progress.clear();
  const RunReport report = log.build_report();
  print_report(get_people_stream(options.json), report);
  std::fputs(hashes.c_str(), get_people_stream(options.json));
  write_json(report, options.json);
  write_junit(report, options.junit, wall_time.get());
  return log.is_sound() && report.status != kUnresolved && is_met(report) ? kExitDone : kExitFailed;
}

}  // namespace

void add_replay(Command app, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  Command command = app.add_verb(
      "replay",
      "Runs a recording again, compares the hash of the state at every tick, and reports the first difference (exit "
      "code 1). A truncated recording replays up to its end, with status 'truncated' and exit code 0. Exit code 1 if "
      "a requirement is not met.",
      "unlatch replay run.log --json replay.json");
  command.add_option("LOG", options->log, "recording made by --log").required();
  command.add_json_option(options->json);
  add_junit_option(command, options->junit);
  add_outputs_option(command, options->outputs);
  command
      .add_option(
          "--hashes", options->hashes,
          "also prints the scenario's name, the tick and the hash of the state every N ticks and at the end, to "
          "compare with a target")
      .type_name("N")
      .not_negative();
  command.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace unlatch::tools
