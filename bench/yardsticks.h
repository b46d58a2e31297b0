// Work that is the same each time, so that what it takes is the machine's doing: what stretches the step is looked for
// with these beside it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace unlatch::bench {

// Some 4 us at 2.5 GHz, in registers: multiplications, each waiting for the one before. Stretched by a slower clock and
// by interruptions, not by a neighbour on the same core, since it leaves most of the core idle.
inline void multiply_in_turn() {
  std::uint64_t x = 1;
  for (int i = 0; i < 3000; ++i) {
    x = x * 6364136223846793005u + 1442695040888963407u;
    asm volatile("" : "+r"(x));  // as long a chain as it looks
  }
}

// Some 2 us, in registers: eight sums that do not wait for one another, as many at once as the core can do. Takes twice
// as long when the core's other hardware thread is at work.
inline void add_side_by_side(int rounds = 2400) {
  std::uint64_t a = 1, b = 2, c = 3, d = 4, e = 5, f = 6, g = 7, h = 8;
  for (int i = 0; i < rounds; ++i) {
    a += 3, b ^= 5, c += 7, d ^= 9, e += 11, f ^= 13, g += 15, h ^= 17;
    asm volatile("" : "+r"(a), "+r"(b), "+r"(c), "+r"(d), "+r"(e), "+r"(f), "+r"(g), "+r"(h));
  }
}

// 128 KiB, a number of each cache line in an order that no prefetcher guesses: part of a core's second cache.
class Reading {
 public:
  void read() {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kLines; ++i) sum += numbers_[i * kScatter % kLines * kNumbersPerLine];
    asm volatile("" : : "r"(sum));
  }

 private:
  static constexpr std::size_t kLines = 2048, kScatter = 769, kNumbersPerLine = 8;
  std::vector<std::uint64_t> numbers_ = std::vector<std::uint64_t>(kLines * kNumbersPerLine, 1);
};

}  // namespace unlatch::bench
