#include "tools/fmu/binary.h"

#include <dlfcn.h>

#include <algorithm>
#include <utility>

#include "tools/fmu/zip_file.h"

namespace unlatch::fmu {

Binary::Binary(const std::string& path, std::string prefix)
    : file_(path.substr(path.rfind('/') + 1)), prefix_(std::move(prefix)) {
  handle_ = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle_ == nullptr) {
    const char* const why = dlerror();
    throw FmuError(file_ + " cannot be loaded: " + (why != nullptr ? why : "unknown reason"));
  }
}

Binary::~Binary() { dlclose(handle_); }

void* Binary::find(const char* name) {
  void* const found = dlsym(handle_, (prefix_ + name).c_str());
  if (found == nullptr) missing_.push_back(prefix_ + name);
  return found;
}

void Binary::require_all() const {
  if (missing_.empty()) return;
  std::string names;
  for (const std::string& name : missing_) names += (names.empty() ? "" : ", ") + name;
  throw FmuError(file_ + " lacks " + names);
}

void Binary::check_version(const char* version, const std::string& major) const {
  if (version != nullptr && std::string(version).starts_with(major)) return;
  throw FmuError(prefix_ + "GetVersion returned " + (version == nullptr ? "null" : version));
}

void Binary::check(int status, const std::string& call) {
  static constexpr const char* kNames[] = {"OK", "Warning", "Discard", "Error", "Fatal", "Pending"};
  worst_ = std::max(worst_, status == kFmiDiscard || status < 0 || status > kFmiFatal ? int{kFmiError} : status);
  if (status == kFmiWarning && warning_.empty())
    warning_ = prefix_ + call + " returned " + prefix_ + "Warning" + quote_message();
  if (status == kFmiOk || status == kFmiWarning) return;
  const bool known = status >= 0 && status < static_cast<int>(std::size(kNames));
  throw FmuError(prefix_ + call + " returned " + (known ? prefix_ + kNames[status] : std::to_string(status)) +
                 quote_message());
}

void Binary::keep_message(std::string message) {
  constexpr std::size_t kLongest = 500;
  std::ranges::replace_if(
      message, [](unsigned char c) { return c < 0x20; }, ' ');
  message_ = message.substr(0, kLongest);
}

std::string Binary::quote_message() const { return message_.empty() ? "" : "; it logged: " + message_; }

}  // namespace unlatch::fmu
