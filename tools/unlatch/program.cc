#include "tools/unlatch/program.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "bridge/core/port.h"
#include "hil/run/recording/log_file.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/base/module.h"
#include "hil/study/optimize/evaluations.h"
#include "tools/common/output.h"
#include "tools/modes/calculix.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/check/graph.h"

namespace unlatch::tools {
namespace {

int fail(const char* what, int code) {
  std::fprintf(stderr, "%s\n", what);
  return code;
}

}  // namespace

int flush_output(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  std::fprintf(stderr, "standard output cannot be written: %s\n", std::strerror(errno));
  return code == kExitDone ? kExitEnvironment : code;
}

int run_program(CommandLine& command_line, int argc, char** argv, int& exit_code) {
  try {
    command_line.parse(argc, argv, exit_code);
    return flush_output(exit_code);
  } catch (const hil::ScenarioError& error) {
    return fail(error.what(), kExitUsage);
  } catch (const hil::SimulationError& error) {
    return fail(error.what(), kExitUsage);
  } catch (const hil::LogWriteError& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const hil::LogError& error) {
    return fail(error.what(), kExitUsage);
  } catch (const bridge::PortError& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const hil::JournalError& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const hil::ModuleError& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const GraphError& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const CalculixError& error) {
    return fail(error.what(), kExitUsage);
  } catch (const CalculixMissing& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const OutputError& error) {
    return fail(error.what(), kExitEnvironment);
  } catch (const std::exception& error) {
    return fail(error.what(), kExitFailed);
  }
}

}  // namespace unlatch::tools
