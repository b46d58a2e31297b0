// Parts that the binaries of both versions of FMI share: functions by name, statuses, messages.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace unlatch::fmu {

enum FmiStatus { kFmiOk = 0, kFmiWarning = 1, kFmiDiscard = 2, kFmiError = 3, kFmiFatal = 4 };

class Binary {
 public:
  // `prefix`: "fmi2". Throws FmuError.
  Binary(const std::string& path, std::string prefix);
  ~Binary();
  Binary(const Binary&) = delete;
  Binary& operator=(const Binary&) = delete;

  // The function PREFIX + name; those that are missing are collected for require_all(). Function: its type.
  template <class Function>
  void find(Function*& function, const char* name) {
    function = reinterpret_cast<Function*>(find(name));
  }
  // Throws FmuError with all functions that are missing.
  void require_all() const;

  // Throws FmuError unless the version is `major`: "2.".
  void check_version(const char* version, const std::string& major) const;
  // Throws FmuError unless the status is OK or a warning. After an error only freeing is allowed, after a fatal one
  // nothing.
  void check(int status, const std::string& call);
  [[nodiscard]] bool may_terminate() const { return worst_ < kFmiError; }
  [[nodiscard]] bool may_free() const { return worst_ < kFmiFatal; }

  void keep_message(std::string message);
  // The first warning since the latest call, "fmi2DoStep returned fmi2Warning; it logged: …", or empty.
  [[nodiscard]] std::string take_warning() { return std::exchange(warning_, {}); }
  // "; it logged: …", or empty.
  [[nodiscard]] std::string quote_message() const;

 private:
  void* find(const char* name);

  const std::string file_, prefix_;
  void* handle_ = nullptr;
  std::vector<std::string> missing_;
  std::string message_;  // the latest
  std::string warning_;
  int worst_ = kFmiOk;
};

}  // namespace unlatch::fmu
