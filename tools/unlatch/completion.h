// Shell completion, from the CLI11 description.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace unlatch::tools {

// A script that the shell sources (bash), or finds on its path (zsh, fish).
std::string build_bash_completion(const CLI::App& app);
std::string build_zsh_completion(const CLI::App& app);
std::string build_fish_completion(const CLI::App& app);

// Paths for --set: the path of every value in the scenario's file, one on each line.
std::string list_scenario_paths(const std::string& scenario);

}  // namespace unlatch::tools
