#include "tools/import/guard.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "tools/import/imported.h"

namespace unlatch::tools {
namespace {

constexpr std::size_t kMostBytes = 16u << 20;
constexpr int kMostDeep = 64;
[[maybe_unused]] constexpr rlim_t kMemory = rlim_t{2} << 30;  // bytes
constexpr rlim_t kTime_s = 60;                                // of CPU
constexpr char kGood = 'g', kBad = 'b';

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// Elements, comments and so on, as far as their nesting goes: parsers recurse, and a deep file would be the end of
// them.
void check_depth(const std::string& text) {
  int depth = 0;
  const auto skip = [&text](std::size_t from, const char* end) {
    const std::size_t found = text.find(end, from);
    return found == std::string::npos ? text.size() : found + std::strlen(end);
  };
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    if (text.compare(at, 4, "<!--") == 0) {
      at = skip(at, "-->");
    } else if (text.compare(at, 9, "<![CDATA[") == 0) {
      at = skip(at, "]]>");
    } else if (text.compare(at, 2, "<!") == 0) {
      throw ImportError("it has a document type declaration, which is not read: remove it");
    } else if (text.compare(at, 2, "<?") == 0) {
      at = skip(at, "?>");
    } else {
      const bool closes = text.compare(at, 2, "</") == 0;
      const std::size_t end = skip(at, ">");
      const bool is_empty = end >= 2 && text[end - 2] == '/';
      if (!is_empty) depth += closes ? -1 : 1;
      if (depth > kMostDeep)
        throw ImportError("it has more than " + std::to_string(kMostDeep) + " elements inside one another");
      at = end;
    }
  }
}

void write_all(int to, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(to, text.data() + done, text.size() - done);
    if (count <= 0) return;
    done += static_cast<std::size_t>(count);
  }
}

[[noreturn]] void work_as_child(int to, const std::function<std::string()>& work) {
  const rlimit time{kTime_s, kTime_s}, none{0, 0};
#ifdef UNLATCH_BOUNDED
  const rlimit memory{kMemory, kMemory};
  setrlimit(RLIMIT_AS, &memory);
#endif
  setrlimit(RLIMIT_CPU, &time);
  setrlimit(RLIMIT_CORE, &none);
  std::string answer;
  try {
    answer = kGood + work();
  } catch (const std::bad_alloc&) {
    answer = std::string(1, kBad) + "it needs more than 2 GiB of memory";
  } catch (const std::exception& error) {
    answer = kBad + std::string(error.what());
  }
  write_all(to, answer);
  _exit(0);
}

}  // namespace

std::string read_xml(const std::string& path) {
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) throw ImportError(std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  if (fstat(fileno(file.get()), &status) != 0 || !S_ISREG(status.st_mode)) throw ImportError("is no regular file");
  if (static_cast<std::size_t>(status.st_size) > kMostBytes) throw ImportError("is larger than 16 MiB");
  std::string text(static_cast<std::size_t>(status.st_size), 0);
  if (std::fread(text.data(), 1, text.size(), file.get()) != text.size()) throw ImportError("cannot be read");
  if (text.find('\0') != std::string::npos) throw ImportError("has a NUL in it: it is no XML in UTF-8");
  check_depth(text);
  return text;
}

std::string compute_apart(const std::function<std::string()>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw ImportError(std::string("no pipe: ") + std::strerror(errno));
  std::fflush(nullptr);  // what waits is written once
  const pid_t child = fork();
  if (child < 0) throw ImportError(std::string("no process: ") + std::strerror(errno));
  if (child == 0) {
    close(ends[0]);
    work_as_child(ends[1], work);
  }
  close(ends[1]);
  std::string answer;
  char bytes[4096];
  for (ssize_t count; (count = read(ends[0], bytes, sizeof bytes)) > 0;)
    answer.append(bytes, static_cast<std::size_t>(count));
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!answer.empty() && WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    if (answer[0] == kGood) return answer.substr(1);
    throw ImportError(answer.substr(1));
  }
  if (WIFSIGNALED(status))
    throw ImportError("its reader has died of it (" + std::string(strsignal(WTERMSIG(status))) +
                      "): it is damaged, or asks for too much");
  throw ImportError("its reader has given up: it is damaged, or asks for too much");
}

}  // namespace unlatch::tools
