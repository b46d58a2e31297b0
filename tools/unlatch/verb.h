// Description of a verb: help, manual page and completion are made from one CLI11 description.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace unlatch::tools {

// `description`: sentences; the first, up to its full stop, colon or semicolon, is the summary of lists. `example`:
// commands, one a line.
CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& description, const std::string& example);

// --json FILE|-; `what` is added to its description.
void add_json_option(CLI::App& command, std::string& target, const std::string& what = "");

// For option->check(): "" or what is wrong. CLI::PositiveNumber says so in four hundred digits.
std::string check_seconds(const std::string& text);

// The exit codes as people read them.
extern const char* const kExitCodesText;

// One option or argument, as the generators want it.
struct OptionText {
  std::vector<std::string> names;    // "--until"; of an argument its name alone, "SCENARIO"
  std::string value;                 // "SECONDS", "FILE"; empty for a flag
  std::string description;           // with unit; ends in the default, if there is one
  std::vector<std::string> choices;  // the values that it takes, if they are few
  bool is_argument = false, is_required = false, is_repeatable = false;
};
std::vector<OptionText> list_options(const CLI::App& command);

std::string get_summary(const CLI::App& command);
std::vector<const CLI::App*> list_verbs(const CLI::App& app);

}  // namespace unlatch::tools
