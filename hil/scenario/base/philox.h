// Counter-based random numbers: Philox4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as easy as 1, 2, 3,
// SC11). A number depends on its key and its counter alone, so samples may be drawn in any order and on any machine.
#pragma once

#include <array>
#include <cstdint>

namespace unlatch::hil {

using PhiloxCounter = std::array<std::uint32_t, 4>;
using PhiloxKey = std::array<std::uint32_t, 2>;

constexpr PhiloxCounter calc_philox(PhiloxCounter counter, PhiloxKey key) {
  constexpr std::uint64_t kMultiplier[2] = {0xD2511F53, 0xCD9E8D57};
  constexpr std::uint32_t kWeyl[2] = {0x9E3779B9, 0xBB67AE85};  // golden ratio, sqrt(3) - 1
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t a = kMultiplier[0] * counter[0], b = kMultiplier[1] * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key = {key[0] + kWeyl[0], key[1] + kWeyl[1]};
  }
  return counter;
}

// Uses of one seed that must not share numbers.
enum class RandomStream : std::uint32_t { kDraw, kPermutation, kShift, kResampling, kChain, kCorner, kSensor };

// Random block of a seed, a stream, and two indices: sample and dimension.
constexpr PhiloxCounter draw_block(std::uint64_t seed, RandomStream stream, std::uint64_t i, std::uint32_t j) {
  return calc_philox(
      {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i >> 32), j, static_cast<std::uint32_t>(stream)},
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
}

constexpr std::uint64_t draw_word(std::uint64_t seed, RandomStream stream, std::uint64_t i, std::uint32_t j) {
  const PhiloxCounter block = draw_block(seed, stream, i, j);
  return std::uint64_t{block[1]} << 32 | block[0];
}

// Middle of one of 2^52 equal parts of (0, 1): never 0 or 1, exact in a double.
constexpr double to_unit(std::uint64_t word) { return (static_cast<double>(word >> 12) + 0.5) * 0x1p-52; }
inline constexpr double kLeastUnit = 0x1p-53;  // smallest value of to_unit(); the greatest is 1 minus this

constexpr double draw_unit(std::uint64_t seed, RandomStream stream, std::uint64_t i, std::uint32_t j) {
  return to_unit(draw_word(seed, stream, i, j));
}

}  // namespace unlatch::hil
