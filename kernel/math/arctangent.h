// The arithmetic of atan2, over doubles (elementary.cc) and over packs (simd/arctangent_packs.h): one text, hence the
// same bits. `T` needs arithmetic, clear_low_bits(), truncate() and look_up().
#pragma once

#include <bit>
#include <cstdint>

namespace unlatch::elementary {

// A number as the unevaluated sum hi + lo, |lo| ≤ ulp(hi).
template <class T>
struct PairT {
  T hi, lo;
};
using Pair = PairT<double>;

inline constexpr Pair kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
inline constexpr Pair kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
inline constexpr double kAtanEighths[2][9] = {  // upper and lower parts of atan(k/8)
    {0, 0x1.fd5ba9aac2f6ep-4, 0x1.f5b75f92c80ddp-3, 0x1.6f61941e4def1p-2, 0x1.dac670561bb4fp-2, 0x1.1e00babdefeb4p-1,
     0x1.4978fa3269ee1p-1, 0x1.700a7c5784634p-1, 0x1.921fb54442d18p-1},
    {0, -0x1.cd37686760c17p-59, 0x1.8ab6e3cf7afbdp-57, -0x1.c63aae6f6e918p-56, 0x1.a2b7f222f65e2p-56,
     -0x1.928df287a668fp-58, 0x1.2419a87f2a458p-56, -0x1.8c34d25aadef6p-56, 0x1.1a62633145c07p-55}};

// Numbers of which atan2 is computed without scaling: the larger one is between these.
inline constexpr double kSmallestPlain = 0x1p-400, kLargestPlain = 0x1p500;
// atan(u) = u to all digits below this.
inline constexpr double kTinyRatio = 0x1p-60;

[[gnu::always_inline]] inline double clear_low_bits(double x, int count) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) >> count << count);
}
[[gnu::always_inline]] inline double truncate(double x) { return static_cast<int>(x); }
[[gnu::always_inline]] inline double look_up(const double* table, double index) {
  return table[static_cast<int>(index)];
}

// a − b exactly (Knuth).
template <class T>
[[gnu::always_inline]] inline PairT<T> calc_difference(const T& a, const T& b) {
  const T hi = a - b;
  const T bb = a - hi;
  return {hi, (a - (hi + bb)) + (bb - b)};
}

// a · b to twice the precision (Dekker, with factors cut after 26 bits).
template <class T>
[[gnu::always_inline]] inline PairT<T> calc_product(const T& a, const T& b) {
  const T a_hi = clear_low_bits(a, 27), a_lo = a - a_hi;
  const T b_hi = clear_low_bits(b, 27), b_lo = b - b_hi;
  const T p = a * b;
  return {p, (((a_hi * b_hi - p) + a_hi * b_lo) + a_lo * b_hi) + a_lo * b_lo};
}

template <class T>
[[gnu::always_inline]] inline T calc_sum(const PairT<T>& a, const PairT<T>& b) {
  const PairT<T> sum = calc_difference(a.hi, -b.hi);
  return sum.hi + (sum.lo + (a.lo + b.lo));
}

// atan(b / a) for 2^-60 a ≤ b ≤ a or b = 0, neither near overflow or underflow. With c = k/8 next to b / a,
//   atan(b/a) = atan(c) + atan(u),  u = (b − c a) / (a + c b),  |u| ≤ 1/16,
// where u is kept to twice the precision and its Taylor series ends at u^13.
template <class T>
[[gnu::always_inline]] inline PairT<T> calc_atan_ratio(const T& b, const T& a) {
  const T k = truncate(T(8.0) * (b / a) + T(0.5));
  const T c = T(0.125) * k;

  // c has four bits, so that its product with the upper 49 bits of a number is exact.
  const T a_hi = clear_low_bits(a, 4), a_lo = a - a_hi;
  const T b_hi = clear_low_bits(b, 4), b_lo = b - b_hi;
  const PairT<T> numerator = calc_difference(b, c * a_hi);
  const T numerator_lo = numerator.lo - c * a_lo;
  const PairT<T> denominator = calc_difference(a, -c * b_hi);
  const T denominator_lo = denominator.lo + c * b_lo;

  const T u = numerator.hi / denominator.hi;
  const PairT<T> product = calc_product(u, denominator.hi);
  const T rest = (((numerator.hi - product.hi) - product.lo) + numerator_lo) - u * denominator_lo;
  const T u_lo = rest / denominator.hi;

  const T z = u * u;
  T p = T(1.0 / 13.0);
  p = p * z - T(1.0 / 11.0);
  p = p * z + T(1.0 / 9.0);
  p = p * z - T(1.0 / 7.0);
  p = p * z + T(1.0 / 5.0);
  p = p * z - T(1.0 / 3.0);
  const PairT<T> sum = calc_difference(look_up(kAtanEighths[0], k), -u);
  return {sum.hi, sum.lo + ((z * u * p + u_lo) + look_up(kAtanEighths[1], k))};
}

}  // namespace unlatch::elementary
