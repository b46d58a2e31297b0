// unlatch completion and unlatch man: what shells and manual readers want, from the same text as --help.
#include <algorithm>

#include "tools/common/output.h"
#include "tools/program/exit_codes.h"
#include "tools/program/manual.h"
#include "tools/unlatch/files/completion.h"
#include "tools/unlatch/files/verbs.h"

namespace unlatch::tools {
namespace {

// One file a page into an existing folder. Throws OutputError.
void write_manuals(const Command& app, const std::string& folder) {
  write_text(build_manual(app, nullptr), folder + "/" + app.get_name() + ".1");
  for (const Command& verb : app.list_verbs()) {
    write_text(build_manual(app, &verb), folder + "/" + app.get_name() + "-" + verb.get_name() + ".1");
  }
}

}  // namespace

void add_completion(Command app, int& exit_code) {
  struct Options {
    std::string shell, scenario, out = "-";
  };
  auto options = std::make_shared<Options>();
  Command command = app.add_verb(
      "completion",
      "Prints the completion script of a shell: verbs, options, files, and the values of a scenario for --set. "
      "With paths it prints only those values, one on each line.",
      "source <(unlatch completion bash)\n"
      "unlatch completion zsh > ~/.zfunc/_unlatch\n"
      "unlatch completion fish > ~/.config/fish/completions/unlatch.fish");
  command.add_option("SHELL", options->shell, "bash, zsh, fish or paths")
      .required()
      .one_of({"bash", "zsh", "fish", "paths"});
  command.add_option("SCENARIO", options->scenario, "scenario file, for paths");
  command.add_option("--out", options->out, "file to write, - for standard output").type_name("FILE").default_shown();
  command.callback([app, options, &exit_code] {
    if (options->shell == "paths" && options->scenario.empty()) refuse_missing("SCENARIO");
    const std::string text = options->shell == "bash"   ? build_bash_completion(app)
                             : options->shell == "zsh"  ? build_zsh_completion(app)
                             : options->shell == "fish" ? build_fish_completion(app)
                                                        : list_scenario_paths(options->scenario);
    write_text(text, options->out);
    exit_code = kExitDone;
  });
}

void add_man(Command app, int& exit_code) {
  struct Options {
    std::string verb, folder;
  };
  auto options = std::make_shared<Options>();
  Command command =
      app.add_verb("man",
                   "Prints a manual page, of a verb or of the program. Installed with the program, so that "
                   "`man unlatch-run` finds it.",
                   "unlatch man run | man -l -\n"
                   "unlatch man --out build/man1");
  command.add_option("VERB", options->verb, "the verb (default: the program)");
  command.add_option("--out", options->folder, "existing folder for all pages").type_name("FOLDER");
  command.callback([app, options, &exit_code] {
    const std::vector<Command> verbs = app.list_verbs();
    const Command* verb = nullptr;
    if (!options->verb.empty()) {
      const auto found =
          std::find_if(verbs.begin(), verbs.end(), [&](const Command& one) { return one.get_name() == options->verb; });
      if (found == verbs.end()) refuse_option("VERB", "there is no verb '" + options->verb + "'; see unlatch --help");
      verb = &*found;
    }
    if (options->folder.empty())
      write_text(build_manual(app, verb), "-");
    else
      write_manuals(app, options->folder);
    exit_code = kExitDone;
  });
}

}  // namespace unlatch::tools
