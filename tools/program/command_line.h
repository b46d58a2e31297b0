// Command lines: verbs, options, help. The only interface to CLI11, whose headers take a compiler four seconds: they
// are included in command_line.cc alone. Help, manual pages and completion are made from the same description.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace unlatch::tools {

// The exit codes as people read them.
extern const char* const kExitCodesText;

// "" or the mistake in a value.
using OptionCheck = std::function<std::string(const std::string&)>;

enum class Seconds { kPositive, kZeroToo };

// An option while it is declared. It refers to the command line.
class OptionHandle {
 public:
  explicit OptionHandle(CLI::Option* option) : option_(option) {}

  OptionHandle type_name(const std::string& name);
  OptionHandle group(const std::string& name);
  OptionHandle required();
  OptionHandle default_shown();  // the target's value at this moment
  OptionHandle delimiter(char separator);
  OptionHandle expected(int least, int most);
  OptionHandle repeatable();  // one value each time

  // A time in s, or with its unit: 3, 3 s, 300 ms. `element`: of each pair the one that it is of, -1: all.
  OptionHandle seconds(Seconds range = Seconds::kPositive, int element = -1);
  OptionHandle check(const OptionCheck& check);
  OptionHandle one_of(const std::vector<std::string>& values);  // "uart:": all that begin so
  OptionHandle within(std::int64_t least, std::int64_t most);
  OptionHandle within(int least, int most) { return within(std::int64_t{least}, std::int64_t{most}); }
  OptionHandle within(double least, double most);
  OptionHandle positive();
  OptionHandle not_negative();

 private:
  CLI::Option* option_;
};

// One option or argument, for the generators of manual pages and completion.
struct OptionText {
  std::vector<std::string> names;    // "--until"; of an argument its name alone, "SCENARIO"
  std::string value;                 // "SECONDS", "FILE"; empty for a flag
  std::string description;           // with unit; ends in the default, if there is one
  std::vector<std::string> choices;  // the values that it takes, if they are few
  bool is_argument = false, is_required = false, is_repeatable = false;
};

// A program's command line, or one of its verbs: a handle, copied at will, valid as long as its CommandLine.
class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  // `description`: sentences; the first, up to its full stop, colon or semicolon, is the summary of lists. `example`:
  // commands, one a line.
  Command add_verb(const std::string& name, const std::string& description, const std::string& example);
  void require_verb();

  // `target` is written when the command line is parsed, and must live until then.
  OptionHandle add_option(const std::string& name, std::string& target, const std::string& description = "");
  OptionHandle add_option(const std::string& name, double& target, const std::string& description = "");
  OptionHandle add_option(const std::string& name, int& target, const std::string& description = "");
  OptionHandle add_option(const std::string& name, std::int64_t& target, const std::string& description = "");
  OptionHandle add_option(const std::string& name, std::vector<std::string>& target,
                          const std::string& description = "");
  OptionHandle add_option(const std::string& name, std::vector<double>& target, const std::string& description = "");
  OptionHandle add_option(const std::string& name, std::vector<int>& target, const std::string& description = "");
  OptionHandle add_option(const std::string& name, std::vector<std::pair<double, std::string>>& target,
                          const std::string& description = "");
  OptionHandle add_flag(const std::string& name, bool& target, const std::string& description = "");
  // --json FILE|-; `what` is added to its description.
  void add_json_option(std::string& target, const std::string& what = "");
  // Not in the help; when it is met, `act` is called with its value and the program ends with exit code 0.
  void add_hidden_action(const std::string& name, const std::function<void(const std::string&)>& act);

  void callback(const std::function<void()>& act);         // when this verb has been parsed
  void parsed_callback(const std::function<void()>& act);  // before that: for checks of several options

  [[nodiscard]] std::string get_name() const;
  [[nodiscard]] std::string get_description() const;
  [[nodiscard]] std::string get_summary() const;
  [[nodiscard]] std::vector<std::string> list_footer() const;  // lines
  [[nodiscard]] std::vector<OptionText> list_options() const;
  [[nodiscard]] std::vector<Command> list_verbs() const;

 private:
  CLI::App* app_;
};

class CommandLine {
 public:
  CommandLine(const std::string& description, const std::string& name, const std::string& footer);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  void set_version(const std::string& text);
  [[nodiscard]] Command get_command() const { return Command(app_); }

  // Runs the callbacks, whose own exceptions pass. False if there is nothing more to do: help was printed, or what is
  // wrong with the command line; `exit_code` then says which.
  bool parse(int argc, char** argv, int& exit_code);

 private:
  CLI::App* app_;
};

// From a callback: the command line is wrong. Printed like the parser's own messages.
[[noreturn]] void refuse_option(const std::string& option, const std::string& why);
[[noreturn]] void refuse_missing(const std::string& option);

}  // namespace unlatch::tools
