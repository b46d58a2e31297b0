// A file that is written beside its target and takes its place when it is whole: a process that ends before leaves the
// target as it was, and a file of the name TARGET.unfinished. Devices and pipes are written as they are.
#pragma once

#include <string>

namespace unlatch::tools {

class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::string& target);
  // An unfinished file is removed.
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  // Path to write to.
  [[nodiscard]] const std::string& path() const { return path_; }
  // It is whole and closed. False, with errno: it cannot be put in its place.
  [[nodiscard]] bool finish();

 private:
  std::string path_, place_;  // of a device the same
  bool finished_ = false;
};

}  // namespace unlatch::tools
