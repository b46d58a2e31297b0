#include "tools/unlatch/files/completion.h"

#include "hil/scenario/scenario.h"
#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::tools {
namespace {

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// Files that an argument accepts: their extension, or "" for any.
std::string get_ending(const OptionText& option) {
  if (option.names[0] == "SCENARIO" || option.names[0] == "--faults") return "yaml";
  return option.is_argument ? "log" : "";
}

bool takes_file(const OptionText& option) {
  return option.is_argument || option.value == "FILE" || option.value == "FOLDER";
}

// Between single quotes, for every shell.
std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c == '\n' ? ' ' : c);
  return quoted + "'";
}

std::vector<std::string> list_long_names(const Command& verb) {
  std::vector<std::string> names;
  for (const OptionText& option : verb.list_options()) {
    if (!option.is_argument) names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

std::vector<std::string> list_verb_names(const Command& app) {
  std::vector<std::string> names;
  for (const Command& verb : app.list_verbs()) names.push_back(verb.get_name());
  return names;
}

// --- The paths of a scenario ----------------------------------------------------------------------------------------

std::string get_item_name(const hil::YamlNode& item, std::size_t index) {
  const hil::YamlNode* const name = item.find("name");
  if (name == nullptr || !name->is_scalar()) return "[" + std::to_string(index) + "]";
  const hil::YamlNode* const subject = item.find("subject");
  return "." + name->text + (subject != nullptr && subject->is_scalar() ? ":" + subject->text : "");
}

void list_paths(const hil::YamlNode& node, const std::string& path, std::string& lines) {
  if (node.is_scalar()) lines += path + "\n";
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const hil::YamlNode& item = node.items[i];
    if (node.is_mapping()) {
      list_paths(item, path.empty() ? node.keys[i].text : path + "." + node.keys[i].text, lines);
    } else {
      list_paths(item, path + get_item_name(item, i), lines);
    }
  }
}

// --- bash -----------------------------------------------------------------------------------------------------------

std::string build_bash_values(const Command& verb) {
  std::string cases;
  for (const OptionText& option : verb.list_options()) {
    if (option.is_argument || option.value.empty()) continue;
    std::string action = ";";  // a value that cannot be guessed
    if (!option.choices.empty()) action = "_unlatch_words " + quote(join(option.choices));
    if (takes_file(option)) action = "_unlatch_files " + quote(get_ending(option));
    if (option.names[0] == "--set") action = "_unlatch_paths";
    for (const std::string& name : option.names) {
      cases +=
          "      " + quote(verb.get_name() + " " + name) + ") " + (action == ";" ? "" : action + "; ") + "return ;;\n";
    }
  }
  return cases;
}

std::string build_bash_verb(const Command& verb) {
  std::string action;
  for (const OptionText& option : verb.list_options()) {
    if (!option.is_argument || !action.empty()) continue;
    action = option.choices.empty() ? "_unlatch_files " + quote(get_ending(option))
                                    : "_unlatch_words " + quote(join(option.choices));
  }
  return "    " + verb.get_name() + ")\n      if [[ $word == -* ]]; then _unlatch_words " +
         quote(join(list_long_names(verb))) + "\n" + (action.empty() ? "" : "      else " + action + "\n") +
         "      fi ;;\n";
}

constexpr const char* kBashHead = R"bash(# bash completion of unlatch, written by `unlatch completion bash`
_unlatch_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$word"); }
_unlatch_files() {  # folders, and files with an ending
  mapfile -t COMPREPLY < <(compgen -d -- "$word"; if [[ $1 ]]; then compgen -f -X "!*.$1" -- "$word"; else compgen -f -- "$word"; fi)
  mapfile -t COMPREPLY < <(printf '%s\n' "${COMPREPLY[@]}" | sort -u)
  [[ ${COMPREPLY[0]} ]] || COMPREPLY=()
  compopt -o filenames 2>/dev/null
}
_unlatch_paths() {  # of the scenario on this line; bash completes only what is behind the last colon
  local scenario whole=${COMP_LINE:0:COMP_POINT} item
  for item in "${COMP_WORDS[@]}"; do [[ $item == *.yaml ]] && scenario=$item; done
  [[ $scenario ]] || return
  whole=${whole##* }
  local before=${whole%"${whole##*:}"}
  mapfile -t COMPREPLY < <(compgen -W "$("${COMP_WORDS[0]}" completion paths "$scenario" 2>/dev/null)" -S = -- "$whole")
  COMPREPLY=("${COMPREPLY[@]#"$before"}")
  compopt -o nospace 2>/dev/null
}
_unlatch() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]}
  COMPREPLY=()
)bash";

}  // namespace

std::string list_scenario_paths(const std::string& scenario) {
  std::string lines;
  list_paths(hil::parse_yaml(hil::read_text_file(scenario, "a scenario")), "", lines);
  return lines;
}

// A path with a colon comes in three words: what is before it, the colon, what is behind.
std::string build_bash_completion(const Command& app) {
  std::string values, verbs;
  for (const Command& verb : app.list_verbs()) {
    values += build_bash_values(verb);
    verbs += build_bash_verb(verb);
  }
  return std::string(kBashHead) + "  if ((COMP_CWORD == 1)); then _unlatch_words " +
         quote(join(list_verb_names(app)) + " " + join(list_long_names(app))) + "; return; fi\n" +
         "  local so_far=${COMP_LINE:0:COMP_POINT}\n"
         "  if [[ $so_far =~ [[:space:]]--set[[:space:]]+[^[:space:]=]*$ ]]; then _unlatch_paths; return; fi\n"
         "  case \"$verb $before\" in\n" +
         values + "  esac\n  case $verb in\n" + verbs + "  esac\n}\ncomplete -F _unlatch unlatch\n";
}

// --- zsh ------------------------------------------------------------------------------------------------------------

namespace {

std::string build_zsh_action(const OptionText& option) {
  if (!option.choices.empty()) return "(" + join(option.choices) + ")";
  if (option.names[0] == "--set") return "_unlatch_paths";
  if (!takes_file(option)) return " ";
  const std::string ending = get_ending(option);
  return ending.empty() ? "_files" : "_files -g \"*." + ending + "\"";
}

// A description inside _arguments: brackets and colons mean something there.
std::string escape_zsh(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '[' || c == ']' || c == ':' ? std::string("\\") + c : std::string(1, c);
  return escaped;
}

std::string build_zsh_verb(const Command& verb) {
  std::string specs;
  int place = 0;
  for (const OptionText& option : verb.list_options()) {
    if (option.is_argument) {
      const std::string where = option.is_repeatable ? "*" : std::to_string(++place);
      specs += " \\\n        " + quote(where + ":" + option.names[0] + ":" + build_zsh_action(option));
      continue;
    }
    for (const std::string& name : option.names) {
      std::string spec = (option.is_repeatable ? "*" : "") + name + "[" + escape_zsh(option.description) + "]";
      if (!option.value.empty()) spec += ":" + escape_zsh(option.value) + ":" + build_zsh_action(option);
      specs += " \\\n        " + quote(spec);
    }
  }
  return "    " + verb.get_name() + ")\n      _arguments" + specs + " ;;\n";
}

}  // namespace

std::string build_zsh_completion(const Command& app) {
  std::string names, verbs;
  for (const Command& verb : app.list_verbs()) {
    names += "      " + quote(verb.get_name() + ":" + escape_zsh(verb.get_summary())) + "\n";
    verbs += build_zsh_verb(verb);
  }
  return "#compdef unlatch\n# zsh completion of unlatch, written by `unlatch completion zsh`\n"
         "_unlatch_paths() {\n  local scenario=${words[(r)*.yaml]}\n  [[ -n $scenario ]] || return 1\n"
         "  local -a paths=(${(f)\"$(unlatch completion paths $scenario 2>/dev/null)\"})\n  compadd -S = -a paths\n}\n"
         "_unlatch() {\n  if (( CURRENT == 2 )); then\n    local -a verbs=(\n" +
         names +
         "    )\n    _describe verb verbs\n    return\n  fi\n  local verb=${words[2]}\n  shift words\n  (( CURRENT-- "
         "))\n"
         "  case $verb in\n" +
         verbs +
         "  esac\n}\nif [[ $zsh_eval_context[-1] == loadautofunc ]]; then _unlatch \"$@\"; else compdef _unlatch "
         "unlatch; fi\n";
}

// --- fish -----------------------------------------------------------------------------------------------------------

std::string build_fish_completion(const Command& app) {
  std::string lines =
      "# fish completion of unlatch, written by `unlatch completion fish`\ncomplete -c unlatch -f\n"
      "function __unlatch_paths\n  set -l scenario (commandline -opc | string match '*.yaml')\n"
      "  test -n \"$scenario\"; and unlatch completion paths $scenario[1] 2>/dev/null | string replace -r '$' "
      "'='\nend\n";
  for (const Command& verb : app.list_verbs()) {
    lines += "complete -c unlatch -n __fish_use_subcommand -a " + verb.get_name() + " -d " + quote(verb.get_summary()) +
             "\n";
    const std::string here = "complete -c unlatch -n '__fish_seen_subcommand_from " + verb.get_name() + "'";
    for (const OptionText& option : verb.list_options()) {
      std::string line = here;
      if (option.is_argument) {
        line += option.choices.empty() ? " -k -a '(__fish_complete_suffix ." + get_ending(option) + ")'"
                                       : " -a " + quote(join(option.choices));
      } else {
        for (const std::string& name : option.names)
          line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        if (!option.value.empty()) line += takes_file(option) ? " -r -F" : " -x";
        if (!option.choices.empty()) line += " -a " + quote(join(option.choices));
        if (option.names[0] == "--set") line += " -a '(__unlatch_paths)'";
        line += " -d " + quote(option.description);
      }
      lines += line + "\n";
    }
  }
  return lines;
}

}  // namespace unlatch::tools
