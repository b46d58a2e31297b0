// Shares of the senders in a ring of arrivals: a sender may have no more places than are free, so that one that sends
// without measure leaves places to the others ("dynamic thresholds", Choudhury and Hahne, IEEE/ACM Transactions on
// Networking 6(2), 1998). Alone it gets half of the ring; of k of them each gets one part in k + 1, and one stays free.
// A search in a short list for each message; fixed memory; one thread takes places, another gives them back.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace unlatch::hil {

class ArrivalShares {
 public:
  // Senders known at a time; further ones, whose messages all wait, count as one.
  static constexpr std::size_t kSenders = 32;

  // Takes a place for a message of `sender`, if it may have one of the `free` ones: the number by which it is given
  // back. The thread that delivers.
  std::optional<std::uint8_t> take(std::int64_t sender, std::size_t free) noexcept {
    const std::size_t place = find(sender);
    std::atomic<std::size_t>& waiting = senders_[place].waiting;
    if (waiting.load(std::memory_order_acquire) >= free) return std::nullopt;
    senders_[place].id = sender;
    waiting.fetch_add(1, std::memory_order_relaxed);
    return static_cast<std::uint8_t>(place);
  }

  // The message has left the ring. The thread that receives.
  void give_back(std::uint8_t place) noexcept { senders_[place].waiting.fetch_sub(1, std::memory_order_release); }

 private:
  struct Sender {
    std::int64_t id = 0;                  // of the thread that delivers
    std::atomic<std::size_t> waiting{0};  // its messages in the ring; 0: the place may become another's
  };

  [[nodiscard]] std::size_t find(std::int64_t sender) const noexcept {
    std::size_t unused = kSenders;
    for (std::size_t i = 0; i < kSenders; ++i) {
      const bool waits = senders_[i].waiting.load(std::memory_order_acquire) > 0;
      if (waits && senders_[i].id == sender) return i;
      if (!waits) unused = std::min(unused, i);
    }
    return unused;
  }

  std::array<Sender, kSenders + 1> senders_;  // the last: all further ones
};

}  // namespace unlatch::hil
