// Messages that were lost on their way, by their numbers: the simulator counts those that it sends, so a number that
// never comes is a loss, whatever the transport and wherever it happened. States that the scenario leaves out
// (timing.states.every) have no number.
#pragma once

#include <cstdint>

namespace unlatch::bridge {

// Numbers of one kind of message. They begin with the first that is heard; a number that comes late is none that was
// lost, and one that comes twice counts once.
class SequenceGaps {
 public:
  void hear(std::int64_t number) noexcept {
    if (number < 0) return;
    if (latest_ < 0) {
      first_ = latest_ = number;
      seen_ = 1;
      return;
    }
    const std::int64_t ahead = number - latest_;
    if (ahead > 0) {
      lost_ += ahead - 1;
      seen_ = ahead < kWindow ? seen_ << ahead | 1 : 1;
      latest_ = number;
    } else if (-ahead < kWindow && number >= first_ && (seen_ >> -ahead & 1) == 0) {
      seen_ |= std::uint64_t{1} << -ahead;
      --lost_;
    }
  }
  [[nodiscard]] std::int64_t get_lost() const noexcept { return lost_; }

 private:
  static constexpr std::int64_t kWindow = 64;  // numbers by which a message may be late

  std::int64_t first_ = -1, latest_ = -1, lost_ = 0;
  std::uint64_t seen_ = 0;  // bit k: number latest_ − k has come
};

}  // namespace unlatch::bridge
