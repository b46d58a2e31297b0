// Manual pages in the format of man(7), from the CLI11 description.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace unlatch::tools {

// Of the program itself, or, with `verb`, of one of its verbs: "unlatch-run(1)".
std::string build_manual(const CLI::App& app, const CLI::App* verb);

}  // namespace unlatch::tools
