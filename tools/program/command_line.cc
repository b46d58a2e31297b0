#include "tools/program/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "hil/scenario/text/expression.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "tools/program/exit_codes.h"

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
    "is wrong; 3 the environment: no permission, no middleware, no space, a program that is not installed";

template <typename Target>
OptionHandle add(CLI::App& app, const std::string& name, Target& target, const std::string& description) {
  return OptionHandle(app.add_option(name, target, description));
}

namespace {

// A number of seconds as the language writes them, `3`, `3 s`, `300 ms`, becomes a plain one with all its digits.
std::string read_seconds(std::string& text, bool zero_too) {
  const std::string mistake = "'" + text + "' is not a " + (zero_too ? "" : "positive ") +
                              "number of seconds; write for example 3, 3 s, 300 ms, 2 min";
  try {
    const hil::Quantity time = hil::evaluate_expression(text, {});
    const bool fits = time.dimension.is_plain() || hil::dimension_of("s").takes(time.dimension);
    if (!fits || !(zero_too ? time.value >= 0 : time.value > 0)) return mistake;
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.17g", time.value);
    text = digits;
    return {};
  } catch (const hil::ExpressionError&) {
    return mistake;
  }
}

// "" or the mistake in a number that is to be positive, or at least 0.
std::string check_number(const std::string& text, bool zero_too) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, value);
  const bool fits = fault == std::errc{} && stop == end && std::isfinite(value) && (zero_too ? value >= 0 : value > 0);
  return fits ? "" : "'" + text + "' is no number " + (zero_too ? "from 0 on" : "above 0");
}

std::vector<std::string> list_option_names(CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : std::as_const(app).get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

const std::string* find_guess(const std::string& wrong, const std::vector<std::string>& known) {
  return hil::find_nearest(wrong, known, std::max<std::size_t>(2, wrong.size() / 3));
}

std::string describe_guess(const std::string& wrong, const std::vector<std::string>& known) {
  const std::string* const nearest = find_guess(wrong, known);
  return nearest == nullptr ? "" : "; did you mean '" + *nearest + "'?";
}

std::vector<CLI::App*> list_verbs(CLI::App& app) {
  return app.get_subcommands([](CLI::App*) { return true; });
}

CLI::App* find_verb(CLI::App& app, const std::string& name) {
  for (CLI::App* verb : list_verbs(app)) {
    if (verb->get_name() == name) return verb;
  }
  return nullptr;
}

// A word that is no option can only be a verb.
bool needs_verb(CLI::App& app) {
  const auto is_argument = [](const CLI::Option* option) { return option->get_positional(); };
  const auto options = std::as_const(app).get_options();
  return !list_verbs(app).empty() && std::none_of(options.begin(), options.end(), is_argument);
}

// The option that stands before its verb, one of `words`.
std::string guess_behind_verb(CLI::App& app, const std::string& option, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    CLI::App* const verb = find_verb(app, word);
    if (verb == nullptr) continue;
    const std::vector<std::string> known = list_option_names(*verb);
    const std::string* const nearest = find_guess(option, known);
    return nearest == nullptr ? "" : "; did you mean '" + *nearest + "' behind '" + word + "'?";
  }
  return "";
}

std::string explain_option(CLI::App& at, const std::string& path, const std::string& name,
                           const std::vector<std::string>& words) {
  const std::vector<std::string> known = list_option_names(at);
  if (std::find(known.begin(), known.end(), name) != known.end()) return "";
  const std::string guess = describe_guess(name, known);
  return path + ": there is no option '" + name + "'" + (guess.empty() ? guess_behind_verb(at, name, words) : guess);
}

std::string explain_verb(CLI::App& at, const std::string& path, const std::string& word) {
  std::vector<std::string> names;
  std::string list;
  for (CLI::App* verb : list_verbs(at)) {
    if (verb->get_group().empty()) continue;
    names.push_back(verb->get_name());
    list += (list.empty() ? "" : ", ") + verb->get_name();
  }
  return path + ": there is no verb '" + word + "'" + describe_guess(word, names) + " known: " + list;
}

// "" or a clearer sentence than the parser's own on what it did not accept.
std::string explain(CLI::App& app, const std::vector<std::string>& words) {
  CLI::App* at = &app;
  std::string path = app.get_name();
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
    const std::string& word = words[i];
    if (word.starts_with("--")) {
      const std::string text = explain_option(*at, path, word.substr(0, word.find('=')),
                                              {words.begin() + static_cast<std::ptrdiff_t>(i), words.end()});
      if (!text.empty()) return text;
    } else if (CLI::App* const verb = find_verb(*at, word)) {
      at = verb;
      path += " " + word;
    } else if (needs_verb(*at)) {
      return explain_verb(*at, path, word);
    }
  }
  return "";
}

}  // namespace

// --- An option ------------------------------------------------------------------------------------------------------

OptionHandle OptionHandle::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

OptionHandle OptionHandle::group(const std::string& name) {
  option_->group(name);
  return *this;
}

OptionHandle OptionHandle::required() {
  option_->required();
  return *this;
}

OptionHandle OptionHandle::default_shown() {
  option_->capture_default_str();
  return *this;
}

OptionHandle OptionHandle::delimiter(char separator) {
  option_->delimiter(separator);
  return *this;
}

OptionHandle OptionHandle::expected(int least, int most) {
  option_->expected(least, most);
  return *this;
}

OptionHandle OptionHandle::repeatable() {
  option_->take_all()->allow_extra_args(false);
  return *this;
}

OptionHandle OptionHandle::seconds(Seconds range, int element) {
  CLI::Validator reader([range](std::string& text) { return read_seconds(text, range == Seconds::kZeroToo); }, "");
  reader.application_index(element);
  option_->transform(reader);
  return *this;
}

OptionHandle OptionHandle::check(const OptionCheck& check) {
  option_->check(check);
  return *this;
}

OptionHandle OptionHandle::one_of(const std::vector<std::string>& values) {
  const CLI::Validator member{CLI::IsMember(values)};
  option_->check(CLI::Validator(
      [member, values](std::string& text) {
        for (const std::string& value : values)
          if (value.ends_with(':') && text.starts_with(value)) return std::string();
        return member(text);
      },
      member.get_description()));
  return *this;
}

OptionHandle OptionHandle::within(std::int64_t least, std::int64_t most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

OptionHandle OptionHandle::within(double least, double most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

OptionHandle OptionHandle::positive() {
  option_->check(CLI::Validator([](std::string& text) { return check_number(text, false); }, ""));
  return *this;
}

OptionHandle OptionHandle::not_negative() {
  option_->check(CLI::Validator([](std::string& text) { return check_number(text, true); }, ""));
  return *this;
}

// --- A command ------------------------------------------------------------------------------------------------------

Command Command::add_verb(const std::string& name, const std::string& description, const std::string& example) {
  CLI::App* const verb = app_->add_subcommand(name, description);
  std::string footer = "Example:";
  for (const std::string& line : CLI::detail::split(example, '\n')) footer += "\n  " + line;
  verb->footer(footer);
  return Command(verb);
}

void Command::require_verb() { app_->require_subcommand(1); }

OptionHandle Command::add_option(const std::string& name, std::string& target, const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, double& target, const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, int& target, const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, std::int64_t& target, const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, std::vector<std::string>& target,
                                 const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, std::vector<double>& target, const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, std::vector<int>& target, const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_option(const std::string& name, std::vector<std::pair<double, std::string>>& target,
                                 const std::string& description) {
  return add(*app_, name, target, description);
}
OptionHandle Command::add_flag(const std::string& name, bool& target, const std::string& description) {
  return OptionHandle(app_->add_flag(name, target, description));
}

void Command::add_json_option(std::string& target, const std::string& what) {
  add_option("--json", target, "the result as JSON, - for standard output" + (what.empty() ? "" : "; " + what))
      .type_name("FILE");
}

void Command::add_hidden_action(const std::string& name, const std::function<void(const std::string&)>& act) {
  app_->add_option_function<std::string>(name,
                                         [act](const std::string& value) {
                                           act(value);
                                           throw CLI::Success();
                                         })
      ->trigger_on_parse()
      ->group("");
}

void Command::callback(const std::function<void()>& act) { app_->callback(act); }
void Command::parsed_callback(const std::function<void()>& act) { app_->parse_complete_callback(act); }

std::string Command::get_name() const { return app_->get_name(); }
std::string Command::get_description() const { return app_->get_description(); }
std::vector<std::string> Command::list_footer() const { return CLI::detail::split(app_->get_footer(), '\n'); }

std::string Command::get_summary() const {
  const std::string text = get_description();
  std::size_t end = 0;
  while (end < text.size() && !((text[end] == '.' || text[end] == ':' || text[end] == ';' || text[end] == '\n') &&
                                (end + 1 == text.size() || text[end + 1] == ' ' || text[end] == '\n')))
    ++end;
  return text.substr(0, end);
}

std::vector<OptionText> Command::list_options() const {
  std::vector<OptionText> arguments, options;
  for (const CLI::Option* option : std::as_const(*app_).get_options()) {
    if (option->get_group().empty()) continue;
    OptionText text = describe(*option);
    (text.is_argument ? arguments : options).push_back(std::move(text));
  }
  arguments.insert(arguments.end(), options.begin(), options.end());
  return arguments;
}

std::vector<Command> Command::list_verbs() const {
  std::vector<Command> verbs;
  for (CLI::App* verb : app_->get_subcommands([](CLI::App*) { return true; })) {
    if (!verb->get_group().empty()) verbs.emplace_back(verb);
  }
  return verbs;
}

// --- The command line -----------------------------------------------------------------------------------------------

CommandLine::CommandLine(const std::string& description, const std::string& name, const std::string& footer)
    : app_(new CLI::App(description, name)) {
  app_->footer(footer);
}

CommandLine::~CommandLine() { delete app_; }

void CommandLine::set_version(const std::string& text) { app_->set_version_flag("--version", text); }

bool CommandLine::parse(int argc, char** argv, int& exit_code) {
  try {
    app_->parse(argc, argv);
    return true;
  } catch (const CLI::ParseError& error) {
    const bool is_unknown = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
                            dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
    if (const std::string clearer = is_unknown ? explain(*app_, {argv + 1, argv + argc}) : ""; !clearer.empty()) {
      std::fprintf(stderr, "%s\nRun with --help for more information.\n", clearer.c_str());
      exit_code = kExitUsage;
      return false;
    }
    exit_code = app_->exit(error) == 0 ? kExitDone : kExitUsage;
    return false;
  }
}

void refuse_option(const std::string& option, const std::string& why) { throw CLI::ValidationError(option, why); }
void refuse_missing(const std::string& option) { throw CLI::RequiredError(option); }

}  // namespace unlatch::tools
