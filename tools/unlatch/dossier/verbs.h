// Verbs of `unlatch`: documents for reviews.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

void add_dossier(Command app, int& exit_code);
void add_requirements(Command app, int& exit_code);

}  // namespace unlatch::tools
