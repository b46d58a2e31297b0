// unlatch: the command line.
#include <csignal>
#include <cstdio>
#include <cstring>

#include "tools/program/exit_codes.h"
#include "tools/unlatch/check/verbs.h"
#include "tools/unlatch/dossier/verbs.h"
#include "tools/unlatch/files/verbs.h"
#include "tools/unlatch/program.h"
#include "tools/unlatch/recordings/verbs.h"
#include "tools/unlatch/run/verbs.h"
#include "tools/unlatch/studies/verbs.h"

namespace unlatch::tools {
namespace {

// The verbs in the order of --help.
void add_verbs(Command program, int& exit_code) {
  for (const auto add :
       {add_init, add_check,  add_run,       add_campaign,     add_optimize, add_hil,        add_linearize, add_replay,
        add_diff, add_report, add_dossier,   add_requirements, add_export,   add_import,     add_resample,  add_compile,
        add_log,  add_watch,  add_telemetry, add_preflight,    add_modes,    add_completion, add_man}) {
    add(program, exit_code);
  }
}

}  // namespace
}  // namespace unlatch::tools

int main(int argc, char** argv) {
  using namespace unlatch;
  constexpr const char* kVersion = "unlatch " UNLATCH_VERSION;
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
    std::puts(kVersion);
    return tools::flush_output(tools::kExitDone);
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write(), to be reported like a full disk
  tools::CommandLine command_line(
      "Simulates separation and deployment in hard real time, with flight software in the loop. Each verb has --help.",
      "unlatch",
      "Exit codes: " + std::string(tools::kExitCodesText) +
          ".\nExample:\n  unlatch check hil/scenarios/boosters/scenario.yaml");
  command_line.set_version(kVersion);
  command_line.get_command().require_verb();
  int exit_code = tools::kExitDone;
  tools::add_verbs(command_line.get_command(), exit_code);
  return tools::run_program(command_line, argc, argv, exit_code);
}
