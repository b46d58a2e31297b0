#include "hil/session/participants/seen_commands.h"

#include <algorithm>
#include <bit>

namespace unlatch::hil {

SeenCommands::Arrival SeenCommands::insert(std::int64_t sequence) noexcept {
  if (sequence <= largest_) {
    if (sequence <= largest_ - kWindow || get(sequence)) return Arrival::kSeen;
    set(sequence);
    return Arrival::kNew;
  }
  if (sequence - largest_ > kWindow && !any_step_) return Arrival::kTooFar;
  any_step_ = false;
  // The numbers in between have not arrived; they take the places of the oldest.
  if (sequence - largest_ >= kWindow) {
    bits_.fill(0);
  } else {
    clear(largest_ + 1, sequence);
  }
  set(sequence);
  largest_ = sequence;
  return Arrival::kNew;
}

// Fewer than kWindow numbers, word by word.
void SeenCommands::clear(std::int64_t first, std::int64_t last) noexcept {
  while (first <= last) {
    const std::int64_t place = first % kWindow, bit = place % kBits;
    const std::int64_t count = std::min(kBits - bit, last - first + 1);
    const std::uint64_t ones = count == kBits ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    bits_[static_cast<std::size_t>(place / kBits)] &= ~(ones << bit);
    first += count;
  }
}

std::int64_t SeenCommands::find(bool seen, std::int64_t sequence, std::int64_t last) const noexcept {
  while (sequence <= last) {
    const std::int64_t place = sequence % kWindow;
    const std::uint64_t word = bits_[static_cast<std::size_t>(place / kBits)];
    const std::uint64_t wanted = (seen ? word : ~word) >> (place % kBits);
    if (wanted != 0) return std::min(sequence + std::countr_zero(wanted), last + 1);
    sequence += kBits - place % kBits;
  }
  return last + 1;
}

std::optional<SeenCommands::Gap> SeenCommands::find_gap(std::int64_t last, std::int64_t count,
                                                        std::int64_t from) const noexcept {
  from = std::max({from, std::int64_t{1}, last - std::min(count, last) + 1, largest_ - kWindow + 1});
  const std::int64_t known = std::min(last, largest_);
  const std::int64_t first = from > known ? from : find(false, from, known);
  if (first > last) return std::nullopt;
  const std::int64_t end = first <= known ? find(true, first, known) : first;
  return Gap{first, (end > known ? last + 1 : end) - first};
}

}  // namespace unlatch::hil
