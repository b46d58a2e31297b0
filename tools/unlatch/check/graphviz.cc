// Runs the graphviz program `dot`, with descriptors and no shell.
#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/unlatch/check/graph.h"

namespace unlatch::tools {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

void write_all(int fd, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) throw GraphError(std::string("no memory for the graph: ") + std::strerror(errno));
    if (n > 0) done += static_cast<std::size_t>(n);
  }
}

// The exit status, or 127 and `error` if the program cannot be started.
int run_dot(int input, int output, int& error) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  char name[] = "dot", format[] = "-Tsvg";
  char* arguments[] = {name, format, nullptr};
  pid_t child = 0;
  error = posix_spawnp(&child, name, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return 127;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

void draw_graph(const std::string& dot, const std::string& svg_path) {
  const Descriptor input(memfd_create("graph", MFD_CLOEXEC));
  if (input.get() < 0) throw GraphError(std::string("no memory for the graph: ") + std::strerror(errno));
  write_all(input.get(), dot);
  lseek(input.get(), 0, SEEK_SET);
  const Descriptor output(open(svg_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (output.get() < 0) throw GraphError(svg_path + ": cannot be written: " + std::strerror(errno));
  int error = 0;
  const int status = run_dot(input.get(), output.get(), error);
  if (status == 0) return;
  struct stat made {};
  if (fstat(output.get(), &made) == 0 && S_ISREG(made.st_mode)) unlink(svg_path.c_str());
  if (status == 127)
    throw GraphError("--graph needs graphviz' program `dot`, which is not there: apt-get install graphviz");
  throw GraphError("graphviz' program `dot` failed with status " + std::to_string(status));
}

}  // namespace unlatch::tools
