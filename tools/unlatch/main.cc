// unlatch: the command line.
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "bridge/port.h"
#include "hil/modules/module.h"
#include "hil/recording/log_file.h"
#include "hil/simulation/simulation.h"
#include "hil/synthesis/evaluations.h"
#include "tools/exit_codes.h"
#include "tools/modes/calculix.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/graph.h"
#include "tools/unlatch/report.h"

namespace unlatch::tools {
namespace {

// In the order of --help.
void add_verbs(Command program, int& exit_code) {
  for (const auto add : {add_init, add_check, add_run, add_campaign, add_optimize, add_hil, add_replay, add_diff, add_report,
                         add_export, add_import, add_log, add_watch, add_preflight, add_modes, add_completion, add_man}) {
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
    return tools::kExitDone;
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write(), to be told like a full disk
  tools::CommandLine command_line(
      "Simulates separation and deployment in hard real time, with flight software in the loop. Each verb has --help.",
      "unlatch",
      "Exit codes: " + std::string(tools::kExitCodesText) +
          ".\nExample:\n  unlatch check hil/scenarios/boosters/scenario.yaml");
  command_line.set_version(kVersion);
  command_line.get_command().require_verb();
  int exit_code = tools::kExitDone;
  // A device that is full takes what is printed in silence, until now.
  const auto finish = [](int code) {
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
    std::fprintf(stderr, "standard output cannot be written: %s\n", std::strerror(errno));
    return code == tools::kExitDone ? tools::kExitEnvironment : code;
  };
  tools::add_verbs(command_line.get_command(), exit_code);

  const auto fail = [](const char* what, int code) {
    std::fprintf(stderr, "%s\n", what);
    return code;
  };
  try {
    command_line.parse(argc, argv, exit_code);
    return finish(exit_code);
  } catch (const hil::ScenarioError& error) {
    return fail(error.what(), tools::kExitUsage);
  } catch (const hil::SimulationError& error) {
    return fail(error.what(), tools::kExitUsage);
  } catch (const hil::LogWriteError& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const hil::LogError& error) {
    return fail(error.what(), tools::kExitUsage);
  } catch (const bridge::PortError& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const hil::JournalError& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const hil::ModuleError& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const tools::GraphError& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const tools::CalculixError& error) {
    return fail(error.what(), tools::kExitUsage);
  } catch (const tools::CalculixMissing& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const tools::OutputError& error) {
    return fail(error.what(), tools::kExitEnvironment);
  } catch (const std::exception& error) {
    return fail(error.what(), tools::kExitFailed);
  }
}
