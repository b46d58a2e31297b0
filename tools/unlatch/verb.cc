#include "tools/unlatch/verb.h"

#include <cmath>

namespace unlatch::tools {
namespace {

// CLI11 describes CLI::IsMember as "{dds,lcm}".
std::vector<std::string> list_choices(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{');
  if (begin == std::string::npos || type.back() != '}') return {};
  return CLI::detail::split(type.substr(begin + 1, type.size() - begin - 2), ',');
}

std::string get_value_name(const CLI::Option& option, const std::vector<std::string>& choices) {
  if (option.get_items_expected_max() == 0) return "";
  if (choices.empty()) {
    const std::string type = option.get_type_name();
    return type.substr(0, type.find(':'));  // "FLOAT:POSITIVE"
  }
  std::string names;
  for (const std::string& choice : choices) names += (names.empty() ? "" : "|") + choice;
  return names;
}

OptionText describe(const CLI::Option& option) {
  OptionText text;
  text.is_argument = option.nonpositional() == false;
  text.is_required = option.get_required();
  text.is_repeatable =
      option.get_items_expected_max() > 1 || option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  text.choices = list_choices(option);
  text.value = text.is_argument ? "" : get_value_name(option, text.choices);
  text.description = option.get_description();
  if (!option.get_default_str().empty()) text.description += " (default: " + option.get_default_str() + ")";
  if (text.is_argument) {
    text.names.push_back(option.get_name());
  } else {
    for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  }
  return text;
}

}  // namespace

const char* const kExitCodesText =
    "0 done; 1 the run or the comparison failed: a fault, an abort, a difference; 2 the command line or an input file "
    "is "
    "wrong; 3 the environment: no permission, no middleware, no disk space, a missing program";

CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& description, const std::string& example) {
  CLI::App* const command = app.add_subcommand(name, description);
  std::string footer = "Example:";
  for (const std::string& line : CLI::detail::split(example, '\n')) footer += "\n  " + line;
  command->footer(footer);
  return command;
}

void add_json_option(CLI::App& command, std::string& target, const std::string& what) {
  command.add_option("--json", target, "the result as JSON, - for standard output" + (what.empty() ? "" : "; " + what))
      ->type_name("FILE");
}

std::string check_seconds(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
             ? std::string{}
             : "'" + text + "' is not a positive number of seconds";
}

std::vector<OptionText> list_options(const CLI::App& command) {
  std::vector<OptionText> arguments, options;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;
    OptionText text = describe(*option);
    (text.is_argument ? arguments : options).push_back(std::move(text));
  }
  arguments.insert(arguments.end(), options.begin(), options.end());
  return arguments;
}

std::string get_summary(const CLI::App& command) {
  const std::string text = command.get_description();
  std::size_t end = 0;
  while (end < text.size() && !((text[end] == '.' || text[end] == ':' || text[end] == ';' || text[end] == '\n') &&
                                (end + 1 == text.size() || text[end + 1] == ' ' || text[end] == '\n')))
    ++end;
  return text.substr(0, end);
}

std::vector<const CLI::App*> list_verbs(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

}  // namespace unlatch::tools
