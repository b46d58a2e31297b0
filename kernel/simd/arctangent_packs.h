// atan2 on lanes: the bits of elementary::atan2(), several angles at once. Compiled once per instruction set, see
// pack.h.
#pragma once

#include "kernel/math/arctangent.h"
#include "kernel/simd/pack.h"
#include "unlatch/elementary.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
UNLATCH_INLINE T clear_low_bits(const T& x, int count) {
  return x & T(__builtin_bit_cast(double, ~std::uint64_t{0} >> count << count));
}

// Whole part of x, 0 ≤ x < 2^51.
template <class T>
UNLATCH_INLINE T truncate(const T& x) {
  const T nearest = (x + T(0x1p52)) - T(0x1p52);
  return nearest - (T(1) & (nearest > x));
}

template <class T>
UNLATCH_INLINE T look_up(const double* table, const T& index) {
  double numbers[T::kWidth];
  store(numbers, index);
  for (double& number : numbers) number = table[static_cast<int>(number)];
  return load<T>(numbers);
}

// The larger of |x| and |y| in [kSmallestPlain, kLargestPlain].
template <class T>
UNLATCH_INLINE T calc_plain_atan2(const T& y, const T& x, const T& larger, const T& smaller, const T& steep) {
  namespace e = elementary;
  const T behind = T(0.0) > x, sign(-0.0);
  const e::PairT<T> ratio = e::calc_atan_ratio(smaller, larger);
  const T tiny = T(e::kTinyRatio) * larger > smaller;
  e::PairT<T> angle{select(tiny, smaller / larger, ratio.hi), ~tiny & ratio.lo};
  const T flip = sign & ((steep & ~behind) | (~steep & behind));
  angle = {flip ^ angle.hi, flip ^ angle.lo};
  const T half(e::kHalfPi.hi), half_lo(e::kHalfPi.lo);
  const e::PairT<T> base{select(steep, half, behind & T(e::kPi.hi)), select(steep, half_lo, behind & T(e::kPi.lo))};
  return e::calc_sum(base, angle) | (sign & y);
}

// Turns: at each place the sine and cosine of an angle times any number, and in the sine's place the angle. `count` is
// rounded up to a multiple of 8.
template <int kWidest>
void update_angles(double* sines, const double* cosines, std::size_t count) {
  using T = Pack<kWidest>;
  const T sign(-0.0);
  constexpr std::size_t kWidth = T::kWidth;
  for (std::size_t i = 0; i < count; i += kWidth) {
    const T y = load<T>(sines + i), x = load<T>(cosines + i);
    const T size_y = ~sign & y, size_x = ~sign & x;
    const T steep = size_y > size_x;
    const T larger = select(steep, size_y, size_x), smaller = select(steep, size_x, size_y);
    const T plain = (larger > T(elementary::kSmallestPlain)) & (T(elementary::kLargestPlain) > larger) &
                    (smaller > T(-1));  // false for what is no number
    if (any(~plain)) [[unlikely]] {
      for (std::size_t k = 0; k < kWidth; ++k) sines[i + k] = elementary::atan2(sines[i + k], cosines[i + k]);
      continue;
    }
    store(sines + i, calc_plain_atan2(y, x, larger, smaller, steep));
  }
}

}  // namespace unlatch::UNLATCH_ISA
