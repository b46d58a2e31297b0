// Runs CalculiX as a separate process, without a shell.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tools/modes/calculix.h"

namespace unlatch::tools {
namespace {

// The environment with one thread: the result does not depend on the machine, and small models are no faster with more.
std::vector<char*> build_environment(std::string& threads) {
  std::vector<char*> list;
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (std::strncmp(*entry, "OMP_NUM_THREADS=", 16) != 0) list.push_back(*entry);
  list.push_back(threads.data());
  list.push_back(nullptr);
  return list;
}

// The lines in which CalculiX says what is wrong.
std::string find_complaints(const std::string& log) {
  std::ifstream stream(log);
  std::string complaints, line;
  while (std::getline(stream, line) && complaints.size() < 1000)
    if (line.find("*ERROR") != std::string::npos) complaints += "\n  " + line;
  return complaints;
}

}  // namespace

void run_calculix(const std::string& program, const std::string& folder, const std::string& job) {
  std::string name = program, argument = job, threads = "OMP_NUM_THREADS=1";
  char* arguments[] = {name.data(), argument.data(), nullptr};
  std::vector<char*> environment = build_environment(threads);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  const std::string log = job + ".log";
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t child = 0;
  const int error = posix_spawnp(&child, name.c_str(), &actions, nullptr, arguments, environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    throw CalculixMissing(program + ": cannot be run: " + std::strerror(error) +
                          "; install Debian's calculix-ccx, or name it with --ccx");
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  const std::string complaints = find_complaints(folder + "/" + log);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !complaints.empty())
    throw CalculixError(folder + "/" + log + ": CalculiX has failed" + complaints);
}

}  // namespace unlatch::tools
