#include "tools/export/node_writer.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

#ifdef UNLATCH_EXPORT_WRITER
// The assembler reads the file; a compiler would take long over it as an array.
asm(R"(
  .section .rodata
  .global unlatch_export_writer, unlatch_export_writer_end
unlatch_export_writer:
  .incbin ")" UNLATCH_EXPORT_WRITER R"("
unlatch_export_writer_end:
  .byte 0
  .text
)");
extern "C" const char unlatch_export_writer[], unlatch_export_writer_end[];
#endif

namespace unlatch::tools {
namespace {

constexpr const char* kInstall = "install Node.js 18 or newer (Debian: apt install nodejs), or write csv or json";
constexpr int kData = 3;  // the writer's descriptor for the lines

std::string_view get_program() {
#ifdef UNLATCH_EXPORT_WRITER
  return {unlatch_export_writer, static_cast<std::size_t>(unlatch_export_writer_end - unlatch_export_writer)};
#else
  return {};
#endif
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

// The program as a file without a name, at its beginning.
int open_program() {
  const std::string_view program = get_program();
  const int file = memfd_create("unlatch-export", MFD_CLOEXEC);
  for (std::size_t done = 0; file >= 0 && done < program.size();) {
    const ssize_t count = write(file, program.data() + done, program.size() - done);
    if (count <= 0) {
      close(file);
      return -1;
    }
    done += static_cast<std::size_t>(count);
  }
  if (file >= 0) lseek(file, 0, SEEK_SET);
  return file;
}

}  // namespace

NodeWriter::NodeWriter(const std::string& format, const std::string& path) {
  if (get_program().empty()) {
    throw NodeMissing("this program was built without the writer of " + format +
                      ", which needs Node.js and npm: " + kInstall + "; then build again: cmake --preset release");
  }
  const Descriptor program(open_program());
  int ends[2];
  if (program.get() < 0 || pipe2(ends, O_CLOEXEC) != 0) {
    throw NodeMissing(std::string("the writer cannot be started: ") + std::strerror(errno));
  }
  const Descriptor lines(ends[0]);
  Descriptor own(ends[1]);
  const char* const arguments[] = {"node", "--input-type=commonjs", "-", format.c_str(), path.c_str(), nullptr};
  if (const int failed = start(program.get(), lines.get(), arguments); failed != 0) {
    throw NodeMissing(format + " needs Node.js, and it cannot be started (" + std::strerror(failed) + "): " + kInstall);
  }
  std::signal(SIGPIPE, SIG_IGN);  // a writer that has ended is reported by the stream, and by finish()
  stream_.reset(fdopen(own.release(), "wb"));
}

// Not posix_spawn, which cannot bind the child's life to this process: a writer left behind would end its file as if it
// were whole. Returns 0, or an errno.
int NodeWriter::start(int program, int lines, const char* const arguments[]) {
  int ends[2];  // carries the reason why exec failed; exec closes it
  if (pipe2(ends, O_CLOEXEC) != 0) return errno;
  const Descriptor failure_reader(ends[0]);
  Descriptor failure_writer(ends[1]);
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ < 0) return errno;
  if (process_ == 0) {  // only calls that are safe between fork and exec
    // Copies for the child alone: above all three numbers first, since dup2 would overwrite one of them.
    const int from = fcntl(program, F_DUPFD_CLOEXEC, kData + 1), data = fcntl(lines, F_DUPFD_CLOEXEC, kData + 1),
              failure = fcntl(failure_writer.get(), F_DUPFD_CLOEXEC, kData + 1);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (from >= 0 && data >= 0 && getppid() == parent && dup2(from, STDIN_FILENO) >= 0 && dup2(data, kData) >= 0) {
      execvp("node", const_cast<char**>(arguments));
      if (errno == ENOENT) execvp("nodejs", const_cast<char**>(arguments));
    }
    const int reason = errno;
    (void)!write(failure, &reason, sizeof reason);
    _exit(127);
  }
  close(failure_writer.release());
  int reason = 0;
  ssize_t count = 0;
  while ((count = read(failure_reader.get(), &reason, sizeof reason)) < 0 && errno == EINTR) {
  }
  if (count <= 0) return 0;
  waitpid(process_, nullptr, 0);
  process_ = -1;
  return reason;
}

NodeWriter::~NodeWriter() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  stream_.reset();
  waitpid(process_, nullptr, 0);
}

bool NodeWriter::finish() {
  const bool sent = std::fflush(stream_.get()) == 0 && std::ferror(stream_.get()) == 0;
  stream_.reset();
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return sent && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace unlatch::tools
