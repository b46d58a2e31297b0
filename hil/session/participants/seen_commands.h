// Numbers of a participant's commands that have arrived, in any order: exact for the latest kWindow of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace unlatch::hil {

class SeenCommands {
 public:
  // Numbers behind the largest that are known one by one, and the largest step ahead of it that is taken.
  static constexpr std::int64_t kWindow = std::int64_t{1} << 17;

  enum class Arrival {
    kNew,
    kSeen,    // arrived before, or kWindow or more behind the largest, where nothing is known any more
    kTooFar,  // more than kWindow ahead of the largest: not taken
  };

  // `sequence` counts from 1.
  Arrival insert(std::int64_t sequence) noexcept;
  // Accepts the next number at any distance: the participant was away, and may have sent any number of commands
  // meanwhile.
  void allow_jump() noexcept { any_step_ = true; }
  struct Gap {
    std::int64_t first = 0, count = 0;
  };
  // First run of numbers that are missing among the `count` up to `last`, from `from` on; none if all have arrived.
  // Numbers older than the window count as arrived.
  [[nodiscard]] std::optional<Gap> find_gap(std::int64_t last, std::int64_t count,
                                            std::int64_t from = 1) const noexcept;
  [[nodiscard]] bool has_all(std::int64_t last, std::int64_t count) const noexcept { return !find_gap(last, count); }

 private:
  static constexpr std::int64_t kBits = 64;
  [[nodiscard]] bool get(std::int64_t sequence) const noexcept {
    const std::int64_t place = sequence % kWindow;
    return (bits_[static_cast<std::size_t>(place / kBits)] >> (place % kBits) & 1U) != 0;
  }
  void set(std::int64_t sequence) noexcept {
    const std::int64_t place = sequence % kWindow;
    bits_[static_cast<std::size_t>(place / kBits)] |= std::uint64_t{1} << (place % kBits);
  }
  void clear(std::int64_t first, std::int64_t last) noexcept;
  // First number from `sequence` to `last` whose state is `seen`; last + 1 if there is none.
  [[nodiscard]] std::int64_t find(bool seen, std::int64_t sequence, std::int64_t last) const noexcept;

  std::array<std::uint64_t, kWindow / kBits>
      bits_{};  // of the numbers in (largest_ - kWindow, largest_], each at its remainder
  std::int64_t largest_ = 0;
  bool any_step_ = false;
};

}  // namespace unlatch::hil
