#include "unlatch/elementary.h"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <vector>

#include "kernel/dispatch/kernels.h"
#include "tests/support/random.h"

namespace unlatch::elementary {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargestUlps = 1.0;  // the header's bound, in units of the exact result's last place
constexpr std::uint64_t kSeed = 20260101;

// MPFR number with automatic release. 200 bits: the oracle's own error is below 2^-140 ulp.
class Exact {
 public:
  Exact() { mpfr_init2(value_, 200); }
  explicit Exact(double x) : Exact() { mpfr_set_d(value_, x, MPFR_RNDN); }
  ~Exact() { mpfr_clear(value_); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  mpfr_ptr get() { return value_; }

 private:
  mpfr_t value_;
};

// |got − exact| in units of the last place of a double as large as the exact value.
double calc_ulps(double got, Exact& exact) {
  const double near = mpfr_get_d(exact.get(), MPFR_RNDZ);
  if (std::isinf(got) || near == 0) return mpfr_get_d(exact.get(), MPFR_RNDN) == got ? 0 : kInf;
  const double ulp = std::nextafter(std::fabs(near), kInf) - std::fabs(near);
  if (std::isinf(ulp)) return kInf;
  Exact error;
  mpfr_sub_d(error.get(), exact.get(), got, MPFR_RNDN);
  mpfr_div_d(error.get(), error.get(), ulp, MPFR_RNDN);
  return std::fabs(mpfr_get_d(error.get(), MPFR_RNDN));
}

struct Worst {
  double ulps = 0, at = 0, at_x = 0;
  void update(double new_ulps, double argument, double x = 0) {
    if (!(new_ulps <= ulps)) *this = {new_ulps, argument, x};
  }
};

void update_sin_cos(double x, Worst& worst_sin, Worst& worst_cos) {
  Exact argument(x), exact_sin, exact_cos;
  mpfr_sin_cos(exact_sin.get(), exact_cos.get(), argument.get(), MPFR_RNDN);
  double s, c;
  sincos(x, s, c);
  worst_sin.update(calc_ulps(s, exact_sin), x);
  worst_cos.update(calc_ulps(c, exact_cos), x);
}

void update_exp(double x, Worst& worst) {
  Exact argument(x), exact;
  mpfr_exp(exact.get(), argument.get(), MPFR_RNDN);
  worst.update(calc_ulps(exp(x), exact), x);
}

void update_atan2(double y, double x, Worst& worst) {
  Exact exact_y(y), exact_x(x), exact;
  mpfr_atan2(exact.get(), exact_y.get(), exact_x.get(), MPFR_RNDN);
  worst.update(calc_ulps(atan2(y, x), exact), y, x);
}

void expect_within_promise(const char* what, const Worst& worst) {
  std::printf("  %-28s %.4f ulp at %a, %a\n", what, worst.ulps, worst.at, worst.at_x);
  EXPECT_LE(worst.ulps, kLargestUlps) << what << " at " << worst.at << ", " << worst.at_x;
}

// Draws a finite double with every bit pattern equally likely: all magnitudes.
double any_double(test::Random& random) {
  for (;;) {
    const double x = std::bit_cast<double>(random.next());
    if (std::isfinite(x)) return x;
  }
}

TEST(Elementary, SineAndCosineAreWithinAnUlp) {
  test::Random random(kSeed);
  struct Range {
    const char* name;
    double size;
    int count;
  };
  for (const Range range : {Range{"sin, cos |x| < 0.8", 0.8, 100000}, Range{"sin, cos |x| < 7", 7, 100000},
                            Range{"sin, cos |x| < 1e5", 1e5, 100000}, Range{"sin, cos |x| < 1e15", 1e15, 30000}}) {
    Worst worst_sin, worst_cos;
    for (int i = 0; i < range.count; ++i) {
      update_sin_cos(random.uniform(-range.size, range.size), worst_sin, worst_cos);
    }
    expect_within_promise(range.name, worst_sin);
    expect_within_promise(range.name, worst_cos);
  }
  Worst worst_sin, worst_cos;
  for (int i = 0; i < 30000; ++i) update_sin_cos(any_double(random), worst_sin, worst_cos);
  expect_within_promise("sin, cos of any double", worst_sin);
  expect_within_promise("sin, cos of any double", worst_cos);
}

// Arguments for which the reduction cancels most, and for which the quadrant changes.
TEST(Elementary, SineAndCosineAreWithinAnUlpAroundMultiplesOfAQuarterPi) {
  Worst worst_sin, worst_cos;
  test::Random random(kSeed);
  Exact quarter_pi, multiple;
  mpfr_const_pi(quarter_pi.get(), MPFR_RNDN);
  mpfr_div_ui(quarter_pi.get(), quarter_pi.get(), 4, MPFR_RNDN);
  for (int i = 1; i <= 12000; ++i) {
    const auto k = i <= 4000 ? static_cast<unsigned long>(i) : static_cast<unsigned long>(random.next() >> (i % 60));
    mpfr_mul_ui(multiple.get(), quarter_pi.get(), k, MPFR_RNDN);
    const double nearest = mpfr_get_d(multiple.get(), MPFR_RNDN);
    for (const double x : {nearest, std::nextafter(nearest, 0), std::nextafter(nearest, kInf)}) {
      update_sin_cos(x, worst_sin, worst_cos);
      update_sin_cos(-x, worst_sin, worst_cos);
    }
  }
  // The double nearest to a multiple of pi/2 relative to its size (Muller, "Elementary Functions").
  update_sin_cos(6381956970095103.0 * 0x1p797, worst_sin, worst_cos);
  expect_within_promise("sin near k pi/4", worst_sin);
  expect_within_promise("cos near k pi/4", worst_cos);
}

// Every power of two and the adjacent doubles, subnormals and the largest double among them: the whole table of the
// reduction, and the limit below which the sine is its argument.
TEST(Elementary, SineAndCosineAreWithinAnUlpAtEveryMagnitude) {
  Worst worst_sin, worst_cos;
  for (int e = -1074; e <= 1023; ++e) {
    const double power = std::ldexp(1.0, e);
    for (const double x : {power, std::nextafter(power, kInf), std::nextafter(power, 0), 1.75 * power}) {
      update_sin_cos(x, worst_sin, worst_cos);
      update_sin_cos(-x, worst_sin, worst_cos);
    }
  }
  for (const double x : {std::numeric_limits<double>::max(), 0x1p-27, 0.75, 0.0}) {
    update_sin_cos(x, worst_sin, worst_cos);
    update_sin_cos(-x, worst_sin, worst_cos);
  }
  expect_within_promise("sin at every magnitude", worst_sin);
  expect_within_promise("cos at every magnitude", worst_cos);
}

TEST(Elementary, SineAndCosineOfSpecialValues) {
  EXPECT_EQ(cos(-0.0), 1.0);
  EXPECT_EQ(cos(0x1p-1074), 1.0);
  EXPECT_TRUE(std::signbit(sin(-0.0)));
  EXPECT_EQ(sin(0.0), 0.0);
  EXPECT_EQ(cos(0.0), 1.0);
  EXPECT_EQ(sin(-0x1p-1074), -0x1p-1074);
  for (const double x : {kInf, -kInf, kNaN}) {
    EXPECT_TRUE(std::isnan(sin(x)));
    EXPECT_TRUE(std::isnan(cos(x)));
  }
}

TEST(Elementary, ExponentialIsWithinAnUlp) {
  test::Random random(kSeed);
  Worst small, all, subnormal, edges;
  for (int i = 0; i < 100000; ++i) update_exp(random.uniform(-1, 1), small);
  for (int i = 0; i < 200000; ++i) update_exp(random.uniform(-708, 709.78), all);
  for (int i = 0; i < 50000; ++i) update_exp(random.uniform(-745.2, -708), subnormal);
  for (int k = -1076; k <= 2048; ++k) {  // multiples of ln 2 / 2, where the reduction changes
    const double x = 0.34657359027997264 * k;
    for (const double neighbour : {x, std::nextafter(x, kInf), std::nextafter(x, -kInf)}) {
      if (neighbour < 709.78) update_exp(neighbour, edges);
    }
  }
  for (int e = -1074; e < 0; ++e) {
    update_exp(std::ldexp(1.0, e), edges);
    update_exp(-std::ldexp(1.0, e), edges);
  }
  expect_within_promise("exp |x| < 1", small);
  expect_within_promise("exp, normal results", all);
  expect_within_promise("exp, subnormal results", subnormal);
  expect_within_promise("exp, where k changes", edges);
}

TEST(Elementary, ExponentialOfSpecialValues) {
  EXPECT_EQ(exp(0.0), 1.0);
  EXPECT_EQ(exp(-0.0), 1.0);
  EXPECT_EQ(exp(kInf), kInf);
  EXPECT_EQ(exp(-kInf), 0.0);
  EXPECT_TRUE(std::isnan(exp(kNaN)));
  constexpr double kLargest = 0x1.62e42fefa39efp+9;  // largest argument with a finite exponential
  EXPECT_TRUE(std::isfinite(exp(kLargest)));
  EXPECT_EQ(exp(std::nextafter(kLargest, kInf)), kInf);
  constexpr double kSmallest = -0x1.74910d52d3051p+9;  // last argument above half of the smallest subnormal
  EXPECT_EQ(exp(kSmallest), 0x1p-1074);
  EXPECT_EQ(exp(std::nextafter(kSmallest, -kInf)), 0.0);
  EXPECT_EQ(exp(std::numeric_limits<double>::max()), kInf);
  EXPECT_EQ(exp(std::numeric_limits<double>::lowest()), 0.0);
}

TEST(Elementary, ArctangentIsWithinAnUlp) {
  test::Random random(kSeed);
  Worst plain, wide, any, edges;
  for (int i = 0; i < 200000; ++i) update_atan2(random.uniform(-1, 1), random.uniform(-1, 1), plain);
  for (int i = 0; i < 50000; ++i) {
    const double size = std::ldexp(1.0, static_cast<int>(random.next() % 140) - 70);
    update_atan2(random.uniform(-1, 1) * size, random.uniform(-1, 1), wide);
  }
  for (int i = 0; i < 50000; ++i) update_atan2(any_double(random), any_double(random), any);
  for (int k = 1; k <= 16; ++k) {  // the table's own points, and the limits between them; all octants and sizes
    for (const double size : {1.0, 3.0, 0x1.fffffffffffffp0, 0x1.8p1000, 0x1.8p-1020, 0x1p-1060}) {
      for (const double x : {size, -size}) {
        const double y = k / 16.0 * size;
        for (const double near : {y, std::nextafter(y, kInf), std::nextafter(y, 0)}) {
          update_atan2(near, x, edges);
          update_atan2(-near, x, edges);
          update_atan2(x, near, edges);
          update_atan2(x, -near, edges);
        }
      }
    }
  }
  expect_within_promise("atan2 |x|, |y| < 1", plain);
  expect_within_promise("atan2, ratios to 2^70", wide);
  expect_within_promise("atan2 of any doubles", any);
  expect_within_promise("atan2, table's edges", edges);
}

// Both arguments over all magnitudes: quotients that overflow, underflow and are subnormal, subnormal arguments.
TEST(Elementary, ArctangentIsWithinAnUlpAtEveryMagnitude) {
  Worst worst;
  for (int e = -1074; e <= 1023; e += 7) {
    for (int f = -1074; f <= 1023; f += 11) {
      const double y = std::ldexp(1.0, e), x = std::ldexp(1.25, f);
      update_atan2(y, x, worst);
      update_atan2(-y, -x, worst);
    }
  }
  for (int e = -1074; e <= -1020; ++e) {  // subnormals against their neighbours
    const double y = std::ldexp(1.0, e);
    for (const double x : {y, std::nextafter(y, kInf), 3 * y, 0x1p-1074, 0x1p-1022}) {
      update_atan2(y, x, worst);
      update_atan2(x, -y, worst);
    }
  }
  expect_within_promise("atan2 at every magnitude", worst);
}

// Angles of joints are computed several at once, see kernel/simd/arctangent_packs.h.
TEST(Elementary, ArctangentsOfEveryWidthHaveTheSameBits) {
  test::Random random(kSeed);
  std::vector<double> y, x;
  const auto add = [&](double a, double b) {
    y.push_back(a);
    x.push_back(b);
  };
  for (int i = 0; i < 40000; ++i) add(random.uniform(-1, 1), random.uniform(-1, 1));
  for (int i = 0; i < 40000; ++i)
    add(random.uniform(-1, 1) * std::ldexp(1.0, -static_cast<int>(random.next() % 80)), 1);
  for (int i = 0; i < 40000; ++i) add(any_double(random), any_double(random));
  const double marks[] = {0.0,      -0.0,     1,       -1,      0.125,     -0.125, 0x1p-60, -0x1p-60,
                          0x1p-400, 0x1p-401, 0x1p500, 0x1p501, 0x1p-1074, kInf,   -kInf,   kNaN};
  for (const double a : marks)
    for (const double b : marks) add(a, b);
  while (y.size() % 8 != 0) add(0, 1);
  for (const InstructionSet set :
       {InstructionSet::kScalar, InstructionSet::k128, InstructionSet::k256, InstructionSet::k512}) {
    if (!is_supported(set)) continue;
    std::vector<double> angles = y;
    get_kernels(set).update_angles(angles.data(), x.data(), angles.size());
    for (std::size_t i = 0; i < y.size(); ++i)
      ASSERT_EQ(std::bit_cast<std::uint64_t>(angles[i]), std::bit_cast<std::uint64_t>(atan2(y[i], x[i])))
          << get_name(set) << ": atan2(" << y[i] << ", " << x[i] << ")";
  }
}

TEST(Elementary, ArctangentOfSpecialValues) {
  const double pi = 3.141592653589793;
  const auto expect_bits = [](double got, double expected) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(got), std::bit_cast<std::uint64_t>(expected)) << got << " " << expected;
  };
  for (const double sign : {1.0, -1.0}) {
    expect_bits(atan2(sign * 0.0, 0.0), sign * 0.0);
    expect_bits(atan2(sign * 0.0, -0.0), sign * pi);
    expect_bits(atan2(sign * 0.0, 2.0), sign * 0.0);
    expect_bits(atan2(sign * 0.0, -2.0), sign * pi);
    expect_bits(atan2(sign * 2.0, 0.0), sign * pi / 2);
    expect_bits(atan2(sign * 2.0, -0.0), sign * pi / 2);
    expect_bits(atan2(sign * 1e300, kInf), sign * 0.0);
    expect_bits(atan2(sign * 1e300, -kInf), sign * pi);
    expect_bits(atan2(sign * kInf, 1e300), sign * pi / 2);
    expect_bits(atan2(sign * kInf, -1e300), sign * pi / 2);
    expect_bits(atan2(sign * kInf, kInf), sign * pi / 4);
    expect_bits(atan2(sign * kInf, -kInf), sign * 2.356194490192345);
    expect_bits(atan2(sign * 0x1p-1074, 1.0), sign * 0x1p-1074);
  }
  EXPECT_TRUE(std::isnan(atan2(kNaN, kInf)));
  EXPECT_TRUE(std::isnan(atan2(kInf, kNaN)));
  EXPECT_TRUE(std::isnan(atan2(0.0, kNaN)));
}

// Bits of a fixed sequence of results. A compiler, optimisation level or instruction set that rounds one of them
// differently shows up here; so does a change of method, which needs a line in CHANGELOG.md.
TEST(Elementary, ResultsHaveTheSameBitsEverywhere) {
  constexpr std::uint64_t kGolden = 0x511c4cc8648237a5;
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a over bytes
  const auto update_hash = [&hash](double x) {
    for (std::uint64_t bits = std::bit_cast<std::uint64_t>(x), i = 0; i < 8; ++i, bits >>= 8) {
      hash = (hash ^ (bits & 0xff)) * 0x100000001b3u;
    }
  };
  test::Random random(kSeed);
  for (int i = 0; i < 50000; ++i) {
    const double angle = random.uniform(-20, 20), far = any_double(random);
    const double y = random.uniform(-1, 1), x = random.uniform(-1, 1);
    for (const double result : {sin(angle), cos(angle), sin(far), cos(far), exp(angle), exp(37 * angle), atan2(y, x),
                                atan2(far, x), atan2(any_double(random), far)}) {
      update_hash(result);
    }
  }
  for (const double x : {kNaN, kInf, -kInf, 0.0, -0.0}) {
    for (const double result : {sin(x), cos(x), exp(x), atan2(x, 1.0), atan2(x, -1.0), atan2(-1.0, x)}) {
      update_hash(result);
    }
  }
  EXPECT_EQ(hash, kGolden) << std::hex << "0x" << hash;
}

}  // namespace
}  // namespace unlatch::elementary
