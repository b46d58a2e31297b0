// Verb of `unlatch`: a scenario before it runs.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

void add_check(Command app, int& exit_code);

}  // namespace unlatch::tools
