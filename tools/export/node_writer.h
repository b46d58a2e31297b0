// Writer of MCAP and Parquet: a program for Node.js inside this one, which receives lines through a pipe.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

namespace unlatch::tools {

// Node.js is not installed, or this program was built without the writer; what() says what to do.
class NodeMissing : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class NodeWriter {
 public:
  // Starts it; `format`: mcap or parquet. Throws NodeMissing. It is killed when the calling thread ends, kill -9
  // included.
  NodeWriter(const std::string& format, const std::string& path);
  // An unfinished process is killed.
  ~NodeWriter();
  NodeWriter(const NodeWriter&) = delete;
  NodeWriter& operator=(const NodeWriter&) = delete;

  [[nodiscard]] std::FILE* get_stream() const { return stream_.get(); }
  // Closes the stream and waits; false if the file is not whole: it has said why on standard error.
  [[nodiscard]] bool finish();

 private:
  int start(int program, int lines, const char* const arguments[]);

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  pid_t process_ = -1;
  std::unique_ptr<std::FILE, Close> stream_;
};

}  // namespace unlatch::tools
