// unlatch init: a scenario to begin with.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "hil/scenario/yaml/yaml_reader.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/files/starters.h"
#include "tools/unlatch/files/verbs.h"

namespace unlatch::tools {
namespace {

namespace fs = std::filesystem;

// A new file; one that is there stays as it is. 0, or the error's number.
int write_new(const fs::path& path, const std::string& text) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  int error = 0;
  for (std::size_t done = 0; done < text.size() && error == 0;) {
    const ssize_t n = write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) error = errno;
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  if (close(fd) < 0 && error == 0) error = errno;
  if (error != 0) unlink(path.c_str());
  return error;
}

int run(const std::string& file, const std::string& like) {
  fs::path path(file);
  if (path.extension() != ".yaml") path += ".yaml";
  const std::string name = path.stem().string();
  if (!hil::is_name(name)) {
    std::fprintf(stderr, "'%s' cannot be the name of a scenario; %s\n", name.c_str(),
                 hil::describe_name_rule(name).c_str());
    return kExitUsage;
  }
  const auto& starters = get_starters();
  const auto starter = std::find_if(starters.begin(), starters.end(), [&](const Starter& s) { return s.name == like; });
  std::string text = starter->text;
  const std::string placeholder = "name: NAME";
  text.replace(text.find(placeholder), placeholder.size(), "name: " + name);
  if (const int error = write_new(path, text)) {
    const char* const what = error == EEXIST ? "this file exists already; give another name" : std::strerror(error);
    std::fprintf(stderr, "%s: %s\n", path.c_str(), what);
    return error == EEXIST ? kExitUsage : kExitEnvironment;
  }
  const fs::path schema = path.parent_path() / "unlatch.schema.json";
  if (const int error = write_new(schema, get_schema()); error != 0 && error != EEXIST)
    std::fprintf(stderr, "%s: %s; editors will not check the scenario\n", schema.c_str(), std::strerror(error));
  std::printf("%s is written. Read it, then run:\n  unlatch check %s\n  unlatch run %s\n", path.c_str(), path.c_str(),
              path.c_str());
  return kExitDone;
}

}  // namespace

void add_init(Command app, int& exit_code) {
  struct Options {
    std::string file, like = "separation";
  };
  auto options = std::make_shared<Options>();
  Command command = app.add_verb(
      "init", "Writes a scenario to start from, with comments, and the schema with which editors check it.",
      "unlatch init first --like array");
  std::vector<std::string> kinds;
  for (const Starter& starter : get_starters()) kinds.push_back(starter.name);
  command.add_option("NAME", options->file, "name of the scenario and of its file NAME.yaml; may include a folder")
      .required();
  command.add_option("--like", options->like, "kind of structure").one_of(kinds).default_shown();
  command.callback([options, &exit_code] { exit_code = run(options->file, options->like); });
}

}  // namespace unlatch::tools
