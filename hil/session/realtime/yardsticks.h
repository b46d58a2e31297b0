// Constant work in registers, to measure machine noise.
#pragma once

#include <cstdint>

namespace unlatch::hil {

// Multiplications, each waiting for the one before: some 4 us at 2.5 GHz. Stretched by a slower clock and by
// interruptions, not by a neighbour on the same core, since it leaves most of the core idle.
inline void multiply_in_turn() noexcept {
  std::uint64_t x = 1;
  for (int i = 0; i < 3000; ++i) {
    x = x * 6364136223846793005u + 1442695040888963407u;
    asm volatile("" : "+r"(x));  // keeps the chain
  }
}

// Eight sums that do not wait for one another, and fill the core: some 2 us. Take up to twice as long while the core's
// other hardware thread is at work.
inline void add_side_by_side(int rounds = 2400) noexcept {
  std::uint64_t a = 1, b = 2, c = 3, d = 4, e = 5, f = 6, g = 7, h = 8;
  for (int i = 0; i < rounds; ++i) {
    a += 3, b ^= 5, c += 7, d ^= 9, e += 11, f ^= 13, g += 15, h ^= 17;
    asm volatile("" : "+r"(a), "+r"(b), "+r"(c), "+r"(d), "+r"(e), "+r"(f), "+r"(g), "+r"(h));
  }
}

}  // namespace unlatch::hil
