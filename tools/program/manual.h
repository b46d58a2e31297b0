// Manual pages in the format of man(7), from the description of the command line.
#pragma once

#include <string>

#include "tools/program/command_line.h"

namespace unlatch::tools {

// Manual page of the program itself or, with `verb`, of one of its verbs: "unlatch-run(1)".
std::string build_manual(const Command& app, const Command* verb);

}  // namespace unlatch::tools
