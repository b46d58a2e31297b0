// 64-bit hash of a block of memory, the same on every machine with its byte order. Four interleaved multiply–xorshift
// chains over the 64-bit words, then mixed: about a nanosecond for four words.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace unlatch {

// Of whole words: bytes behind the last one do not count.
inline std::uint64_t calc_words_hash(std::span<const std::byte> bytes) noexcept {
  constexpr std::uint64_t kPrime = 0x9E3779B97F4A7C15ull;
  std::uint64_t chains[4] = {1, 2, 3, 4};
  for (std::size_t i = 0; i < bytes.size() / 8; ++i) {
    std::uint64_t word;
    std::memcpy(&word, bytes.data() + 8 * i, 8);
    std::uint64_t& chain = chains[i % 4];
    chain = std::rotl(chain ^ word, 29) * kPrime;
  }
  std::uint64_t hash = bytes.size();
  for (const std::uint64_t chain : chains) {
    hash = (hash ^ chain ^ (chain >> 32)) * kPrime;
    hash ^= hash >> 29;
  }
  return hash;
}

}  // namespace unlatch
