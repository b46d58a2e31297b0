// A scenario as Source messages, so that an observer can build it without a file: its text and each --set, a NUL behind
// each, cut into parts.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hil/messages/messages.h"

namespace unlatch::hil {

// Of at least one part; sequence is left 0. `text` and `overrides` have no NUL in them: the loader sees to that.
std::vector<SourceMessage> build_source(const std::string& text, const std::vector<std::string>& overrides,
                                        std::int64_t session);

// Puts together the parts of one session, in whatever order they come.
class SourceText {
 public:
  // Parts of another session, or of another size than the first one, are left out.
  void add(const SourceMessage& part);

  [[nodiscard]] std::size_t get_parts() const { return parts_.size(); }  // 0: none was received yet
  [[nodiscard]] std::size_t get_missing() const { return missing_; }
  [[nodiscard]] bool is_complete() const { return !parts_.empty() && missing_ == 0; }

  // Of a complete one: the text, then the overrides. Empty if it does not end in a NUL.
  [[nodiscard]] std::vector<std::string> split() const;

 private:
  static constexpr std::int32_t kMaxParts = 1024;  // 2 MiB: a scenario has at most 1 MiB
  std::int64_t session_ = 0;
  std::vector<std::string> parts_;
  std::vector<bool> received_;
  std::size_t missing_ = 0;
};

}  // namespace unlatch::hil
