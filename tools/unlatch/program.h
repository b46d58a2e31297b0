// The run of a program with verbs: what they throw becomes a message on standard error and an exit code.
#pragma once

#include "tools/program/command_line.h"

namespace unlatch::tools {

// Parses the command line, which calls the verb, and flushes standard output. `exit_code`: the verb writes it. Returns
// the exit code of the program.
int run_program(CommandLine& command_line, int argc, char** argv, int& exit_code);

// Flushes standard output, which a full device fails only now. Returns `code`, or that of the environment after a
// message.
int flush_output(int code);

}  // namespace unlatch::tools
