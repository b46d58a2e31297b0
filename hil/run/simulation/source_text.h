// Scenario as Source messages, so that an observer can build it without a file: its text and each --set, a NUL behind
// each, cut into parts.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hil/session/messages/messages.h"

namespace unlatch::hil {

// Parts, at least one; sequence is left 0. `text` and `overrides` have no NUL in them: the loader refuses it.
std::vector<SourceMessage> build_source(const std::string& text, const std::vector<std::string>& overrides,
                                        std::int64_t session);

// Text put together from the parts of one session, in any order.
class SourceText {
 public:
  // Adds a part; parts of another session, or of another size than the first one, are left out.
  void add(const SourceMessage& part);

  [[nodiscard]] std::size_t get_parts() const { return parts_.size(); }  // 0: none received yet
  [[nodiscard]] std::size_t get_missing() const { return missing_; }
  [[nodiscard]] bool is_complete() const { return !parts_.empty() && missing_ == 0; }

  // Text and overrides, in this order, once complete. Empty if it does not end in a NUL.
  [[nodiscard]] std::vector<std::string> split() const;

 private:
  static constexpr std::int32_t kMaxParts = 9216;  // 18 MiB: a scenario has at most 1 MiB, and 16 MiB of tables
  std::int64_t session_ = 0;
  std::vector<std::string> parts_;
  std::vector<bool> received_;
  std::size_t missing_ = 0;
};

}  // namespace unlatch::hil
