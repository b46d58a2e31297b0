#include "tools/common/unfinished_file.h"

#include <cstdio>
#include <filesystem>

namespace unlatch::tools {

UnfinishedFile::UnfinishedFile(const std::string& target) : path_(target), place_(target) {
  std::error_code error;
  const auto type = std::filesystem::status(target, error).type();
  if (type != std::filesystem::file_type::regular && type != std::filesystem::file_type::not_found) return;
  const auto real = std::filesystem::canonical(target, error);  // of a symbolic link the file that it names
  if (!error) place_ = real.string();
  path_ = place_ + ".unfinished";
}

UnfinishedFile::~UnfinishedFile() {
  if (!finished_ && path_ != place_) std::remove(path_.c_str());
}

bool UnfinishedFile::finish() {
  if (path_ != place_ && std::rename(path_.c_str(), place_.c_str()) != 0) return false;
  finished_ = true;
  return true;
}

}  // namespace unlatch::tools
