// Shell completion, from the description of the command line.
#pragma once

#include <string>

#include "tools/program/command_line.h"

namespace unlatch::tools {

// A script that the shell sources (bash), or finds on its path (zsh, fish).
std::string build_bash_completion(const Command& app);
std::string build_zsh_completion(const Command& app);
std::string build_fish_completion(const Command& app);

// Paths for --set: the path of every value in the scenario's file, one on each line.
std::string list_scenario_paths(const std::string& scenario);

}  // namespace unlatch::tools
