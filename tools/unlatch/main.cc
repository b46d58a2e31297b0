// unlatch: the command line.
#include <csignal>
#include <cstdio>

#include "bridge/port.h"
#include "hil/recording/log_file.h"
#include "hil/simulation/simulation.h"
#include "tools/exit_codes.h"
#include "tools/modes/calculix.h"
#include "tools/unlatch/commands.h"
#include "tools/unlatch/graph.h"
#include "tools/unlatch/report.h"

int main(int argc, char** argv) {
  using namespace unlatch;
  CLI::App app{
      "Simulates separation and deployment in hard real time, with flight software in the loop. Each verb has --help.",
      "unlatch"};
  app.footer("Exit codes: " + std::string(tools::kExitCodesText) +
             ".\nExample:\n  unlatch check hil/scenarios/boosters/scenario.yaml");
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write(), to be told like a full disk
  app.set_version_flag("--version", "unlatch " UNLATCH_VERSION);
  app.require_subcommand(1);
  int exit_code = tools::kExitDone;
  tools::add_init(app, exit_code);
  tools::add_check(app, exit_code);
  tools::add_run(app, exit_code);
  tools::add_hil(app, exit_code);
  tools::add_replay(app, exit_code);
  tools::add_diff(app, exit_code);
  tools::add_report(app, exit_code);
  tools::add_export(app, exit_code);
  tools::add_import(app, exit_code);
  tools::add_log(app, exit_code);
  tools::add_watch(app, exit_code);
  tools::add_preflight(app, exit_code);
  tools::add_modes(app, exit_code);
  tools::add_completion(app, exit_code);
  tools::add_man(app, exit_code);

  const auto fail = [](const char* what, int code) {
    std::fprintf(stderr, "%s\n", what);
    return code;
  };
  try {
    app.parse(argc, argv);
    return exit_code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? tools::kExitDone : tools::kExitUsage;
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
