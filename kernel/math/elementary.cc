#include "unlatch/elementary.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kernel/math/arctangent.h"

namespace unlatch::elementary {
namespace {

// a · b, 128 bits.
struct Product {
  std::uint64_t high, low;
};
Product multiply(std::uint64_t a, std::uint64_t b) {
#if defined(__SIZEOF_INT128__)
  __extension__ typedef unsigned __int128 Wide;
  const Wide product = static_cast<Wide>(a) * b;
  return {static_cast<std::uint64_t>(product >> 64), static_cast<std::uint64_t>(product)};
#else  // processors of 32 bits
  constexpr std::uint64_t kLow = 0xffffffff;
  const std::uint64_t a0 = a & kLow, a1 = a >> 32, b0 = b & kLow, b1 = b >> 32;
  const std::uint64_t low = a0 * b0, cross = a0 * b1, middle = (low >> 32) + (cross & kLow) + a1 * b0;
  return {a1 * b1 + (cross >> 32) + (middle >> 32), (middle << 32) | (low & kLow)};
#endif
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

double calc_power_of_two(int exponent) {  // −1022 ≤ exponent ≤ 1023
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}

// --- Sine and cosine ------------------------------------------------------------------------------------------------

// 2/pi after 64 zero bits: bit j after the binary point is bit 63 + j of the array, most significant first.
constexpr std::uint64_t kTwoOverPi[20] = {
    0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
    0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};
constexpr std::uint64_t kHalfPi64 = 0xc90fdaa22168c234;  // pi/2 · 2^63

struct Reduced {
  Pair r;        // |r| ≤ pi/4
  int quadrant;  // x = quadrant · pi/2 + r, modulo 2 pi
};

// Payne–Hanek for a finite x ≥ 1/2. With x = m · 2^e, bits of 2/pi down to 2^(2−e) contribute multiples of four
// quadrants; the 192 bits below them fix x · 2/pi modulo 4 to 2^-137. No double comes nearer to a multiple of pi/2 than
// some 2^-61, so 2^-63 of relative accuracy are left.
Reduced calc_reduced(double x) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t m = (bits & 0xfffffffffffffu) | 0x10000000000000u;
  const unsigned first = static_cast<unsigned>(bits >> 52) - 1075 + 62;  // array index of bit j = e − 1
  const std::uint64_t* const word = kTwoOverPi + first / 64;
  const unsigned shift = first % 64;
  const auto window = [&](int i) { return (word[i] << shift) | (word[i + 1] >> 1 >> (63 - shift)); };

  // m · window modulo 2^192: two bits of quadrant, 190 of fraction.
  const Product low = multiply(m, window(2)), middle = multiply(m, window(1));
  const std::uint64_t middle_word = middle.low + low.high;
  const std::uint64_t high = m * window(0) + middle.high + (middle_word < low.high ? 1 : 0);

  // The fraction to the nearest quadrant: a half or more is counted back from the next one.
  std::uint64_t f0 = (high << 2) | (middle_word >> 62);
  std::uint64_t f1 = (middle_word << 2) | (low.low >> 62);
  const std::uint64_t back = f0 >> 63;
  f0 ^= 0 - back;
  f1 ^= 0 - back;

  // Normalise (f0 is never 0), multiply by pi/2, split at 53 bits.
  const int zeros = std::countl_zero(f0);
  const auto [a0, a1] = multiply((f0 << zeros) | (f1 >> (64 - zeros)), kHalfPi64);
  const double sign = back != 0 ? -1.0 : 1.0;
  const double hi = static_cast<double>(static_cast<std::int64_t>(a0 >> 11)) * calc_power_of_two(-52 - zeros);
  const double lo = static_cast<double>(static_cast<std::int64_t>(((a0 & 0x7ff) << 42) | (a1 >> 22))) *
                    calc_power_of_two(-105 - zeros);
  return {{sign * hi, sign * lo}, static_cast<int>((high >> 62) + back) & 3};
}

// Taylor to r^17, whose next term is below 2^-63 at pi/4.
double calc_sin_kernel(Pair r) {
  const double z = r.hi * r.hi;
  double p = 1.0 / 355687428096000.0;
  p = p * z - 1.0 / 1307674368000.0;
  p = p * z + 1.0 / 6227020800.0;
  p = p * z - 1.0 / 39916800.0;
  p = p * z + 1.0 / 362880.0;
  p = p * z - 1.0 / 5040.0;
  p = p * z + 1.0 / 120.0;
  p = p * z - 1.0 / 6.0;
  return r.hi + (z * r.hi * p + (1.0 - 0.5 * z) * r.lo);
}

// Taylor to r^16; 1 − z/2 is carried with its rounding error.
double calc_cos_kernel(Pair r) {
  const double z = r.hi * r.hi;
  double p = 1.0 / 20922789888000.0;
  p = p * z - 1.0 / 87178291200.0;
  p = p * z + 1.0 / 479001600.0;
  p = p * z - 1.0 / 3628800.0;
  p = p * z + 1.0 / 40320.0;
  p = p * z - 1.0 / 720.0;
  p = p * z + 1.0 / 24.0;
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * z * p - r.hi * r.lo));
}

}  // namespace

void sincos(double x, double& sine, double& cosine) noexcept {
  const double size = std::fabs(x);
  if (!(size < kInf)) {
    sine = cosine = kNaN;
    return;
  }
  if (size < 0x1p-27) {  // nothing of x³ reaches the result; keeps −0 and subnormals
    sine = x;
    cosine = 1.0;
    return;
  }
  const Reduced reduced = size < 0.75 ? Reduced{{size, 0.0}, 0} : calc_reduced(size);
  const double s = calc_sin_kernel(reduced.r), c = calc_cos_kernel(reduced.r);
  const bool odd = (reduced.quadrant & 1) != 0;
  const double size_sine = odd ? c : s;
  cosine = odd ? s : c;
  if (((reduced.quadrant + 1) & 2) != 0) cosine = -cosine;
  sine = ((reduced.quadrant & 2) != 0) != (x < 0) ? -size_sine : size_sine;
}

double sin(double x) noexcept {
  double sine, cosine;
  sincos(x, sine, cosine);
  return sine;
}

double cos(double x) noexcept {
  double sine, cosine;
  sincos(x, sine, cosine);
  return cosine;
}

// x = k ln 2 + r, |r| ≤ ln 2 / 2: the upper part of ln 2 has 41 bits, so k times it is exact. Taylor to r^13; 1 + r is
// carried with its rounding error. 2^k is applied in two factors, of which only the last can round, overflow or
// underflow.
double exp(double x) noexcept {
  if (x != x) return kNaN;
  if (x > 710.0) return kInf;
  if (x < -746.0) return 0.0;
  constexpr double kLog2E = 0x1.71547652b82fep+0;
  constexpr Pair kLn2{0x1.62e42fefa3000p-1, 0x1.3de6af278ece6p-42};
  const int k = static_cast<int>(x * kLog2E + (x < 0 ? -0.5 : 0.5));
  const Pair r = calc_difference(x - k * kLn2.hi, k * kLn2.lo);

  const double s = r.hi * r.hi;
  double odd = 1.0 / 6227020800.0;  // even and odd powers side by side: half as long a chain
  odd = odd * s + 1.0 / 39916800.0;
  odd = odd * s + 1.0 / 362880.0;
  odd = odd * s + 1.0 / 5040.0;
  odd = odd * s + 1.0 / 120.0;
  odd = odd * s + 1.0 / 6.0;
  double even = 1.0 / 479001600.0;
  even = even * s + 1.0 / 3628800.0;
  even = even * s + 1.0 / 40320.0;
  even = even * s + 1.0 / 720.0;
  even = even * s + 1.0 / 24.0;
  even = even * s + 0.5;
  const double p = odd * r.hi + even;
  const double one_plus = 1.0 + r.hi;
  const double y = one_plus + (((1.0 - one_plus) + r.hi) + (r.lo + s * p));
  const int half = k / 2;
  return y * calc_power_of_two(half) * calc_power_of_two(k - half);
}

// x = m 2^k with m in [sqrt(1/2), sqrt(2)), log m = 2 atanh s, s = (m − 1) / (m + 1); s² ≤ 0.0295, so that the series
// ends below 2^-60 at s^23. k ln 2 in two parts, the first exact for every k.
double log(double x) noexcept {
  if (!(x >= std::numeric_limits<double>::min()) || !(x < kInf)) return kNaN;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  int k = static_cast<int>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0xfffffffffffffu) | 0x3ff0000000000000u);
  if (m > 1.4142135623730951) {
    m *= 0.5;
    ++k;
  }
  const double f = m - 1.0;  // exact
  const double s = f / (2.0 + f), z = s * s;
  double p = 1.0 / 23.0;
  p = p * z + 1.0 / 21.0;
  p = p * z + 1.0 / 19.0;
  p = p * z + 1.0 / 17.0;
  p = p * z + 1.0 / 15.0;
  p = p * z + 1.0 / 13.0;
  p = p * z + 1.0 / 11.0;
  p = p * z + 1.0 / 9.0;
  p = p * z + 1.0 / 7.0;
  p = p * z + 1.0 / 5.0;
  p = p * z + 1.0 / 3.0;
  // 2 s = f − s f, which keeps the digits of f; the rest is small beside it
  const double rest = s * (2.0 * z * p - f);
  if (k == 0) return f + rest;
  constexpr double kHigh = 0x1.62e42fefa0000p-1, kLow = 0x1.cf79abc9e3b3ap-40;  // ln 2
  return k * kHigh + (f + (rest + k * kLow));
}

double atan2(double y, double x) noexcept {
  if (y != y || x != x) return kNaN;
  double a = std::fabs(x), b = std::fabs(y);
  if (a == kInf || b == kInf) {  // an infinity is one, and all else zero beside it
    a = a == kInf ? 1.0 : 0.0;
    b = b == kInf ? 1.0 : 0.0;
  }
  const bool behind = std::signbit(x);
  const bool steep = b > a;
  if (steep) {
    const double swap = a;
    a = b;
    b = swap;
  }

  Pair angle{0, 0};  // atan(b / a), in [0, pi/4]
  if (b < a * kTinyRatio) {
    angle.hi = b / a;  // with gradual underflow, which only the first octant shows
  } else if (b > 0) {  // scaled where a product could overflow or underflow; changes no bit
    const double scale = a > kLargestPlain ? 0x1p-600 : a < kSmallestPlain ? 0x1p600 : 1.0;
    angle = calc_atan_ratio(b * scale, a * scale);
  }
  if (steep != behind) angle = {-angle.hi, -angle.lo};
  const Pair base = steep ? kHalfPi : behind ? kPi : Pair{0, 0};
  return std::copysign(calc_sum(base, angle), y);
}

}  // namespace unlatch::elementary
