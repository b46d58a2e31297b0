// Sessions of other simulators that have been reported: each is reported once, and only the first few, so that a flood of
// invented ones ends. Fixed memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace unlatch::hil {

class OtherSessions {
 public:
  static constexpr std::size_t kMost = 8;

  // True if this session is to be reported now.
  bool is_news(std::int64_t session) noexcept {
    const auto end = sessions_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (count_ == kMost || std::find(sessions_.begin(), end, session) != end) return false;
    sessions_[count_++] = session;
    return true;
  }
  void forget() noexcept { count_ = 0; }

 private:
  std::array<std::int64_t, kMost> sessions_{};
  std::size_t count_ = 0;
};

}  // namespace unlatch::hil
