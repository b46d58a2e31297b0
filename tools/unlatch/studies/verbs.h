// Verbs of `unlatch`: many runs.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

void add_campaign(Command app, int& exit_code);
void add_optimize(Command app, int& exit_code);

}  // namespace unlatch::tools
