// Verbs of `unlatch`: runs of a scenario, and sessions.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

void add_run(Command app, int& exit_code);
void add_hil(Command app, int& exit_code);
void add_linearize(Command app, int& exit_code);
void add_preflight(Command app, int& exit_code);
void add_watch(Command app, int& exit_code);
void add_log(Command app, int& exit_code);
void add_telemetry(Command app, int& exit_code);

}  // namespace unlatch::tools
