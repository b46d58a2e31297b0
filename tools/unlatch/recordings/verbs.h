// Verbs of `unlatch`: recordings.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

void add_replay(Command app, int& exit_code);
void add_diff(Command app, int& exit_code);
void add_report(Command app, int& exit_code);
void add_export(Command app, int& exit_code);

}  // namespace unlatch::tools
