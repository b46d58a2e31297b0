// Verbs of `unlatch`: files to begin with.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

void add_init(Command app, int& exit_code);
void add_compile(Command app, int& exit_code);
void add_import(Command app, int& exit_code);
void add_resample(Command app, int& exit_code);
void add_modes(Command app, int& exit_code);
void add_completion(Command app, int& exit_code);
void add_man(Command app, int& exit_code);

}  // namespace unlatch::tools
