#include "hil/scenario/base/normal.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

template <std::size_t n>
double calc_polynomial(const double (&coefficients)[n], double x) {
  double sum = 0;
  for (std::size_t i = n; i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

// Wichura's rational approximations: |p − 1/2| ≤ 0.425, then by r = sqrt(−ln p) up to 5, then beyond.
constexpr double kA[] = {3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                         1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                         3.3430575583588128105e+4, 2.5090809287301226727e+3};
constexpr double kB[] = {1.0,
                         4.2313330701600911252e+1,
                         6.8718700749205790830e+2,
                         5.3941960214247511077e+3,
                         2.1213794301586595867e+4,
                         3.9307895800092710610e+4,
                         2.8729085735721942674e+4,
                         5.2264952788528545610e+3};
constexpr double kC[] = {1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                         3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                         2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr double kD[] = {1.0,
                         2.05319162663775882187e0,
                         1.67638483018380384940e0,
                         6.89767334985100004550e-1,
                         1.48103976427480074590e-1,
                         1.51986665636164571966e-2,
                         5.47593808499534494600e-4,
                         1.05075007164441684324e-9};
constexpr double kE[] = {6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                         2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                         2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr double kF[] = {1.0,
                         5.99832206555887937690e-1,
                         1.36929880922735805310e-1,
                         1.48753612908506148525e-2,
                         7.86869131145613259100e-4,
                         1.84631831751005468180e-5,
                         1.42151175831644588870e-7,
                         2.04426310338993978564e-15};

}  // namespace

double calc_log(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);  // exact; m in [1/2, 1)
  if (m < std::numbers::sqrt2 / 2) {
    m *= 2;
    --exponent;
  }
  const double s = (m - 1) / (m + 1), s2 = s * s;
  double y = 2 * s * (1 + s2 * (1.0 / 3 + s2 * (1.0 / 5 + s2 * (1.0 / 7 + s2 * (1.0 / 9)))));  // 2 artanh(s), 1e-9
  const double e = elementary::exp(y);
  y += 2 * (m - e) / (m + e);
  constexpr double kUpper = 0x1.62e42fefa38p-1, kLower = 0x1.ef35793c7673p-45;  // ln 2 in two parts
  return exponent * kUpper + (y + exponent * kLower);
}

double calc_normal_cdf(double z) {
  const double a = z < 0 ? -z : z;
  constexpr double kDensity0 = 0.3989422804014326779;  // 1 / sqrt(2 pi)
  const double density = kDensity0 * elementary::exp(-0.5 * a * a);
  constexpr double kMiddle = 2.5;
  constexpr int kTerms = 60, kFractions = 120;  // both converge well before
  if (a < kMiddle) {
    double term = z, sum = z;
    for (int k = 1; k < kTerms; ++k) {
      term *= z * z / (2 * k + 1);
      sum += term;
    }
    return 0.5 + density * sum;
  }
  double fraction = a;  // a + 1/(a + 2/(a + 3/(a + …)))
  for (int k = kFractions; k >= 1; --k) fraction = a + k / fraction;
  const double tail = density / fraction;
  return z < 0 ? tail : 1 - tail;
}

double calc_normal_quantile(double p) {
  const double q = p - 0.5;
  constexpr double kCentral = 0.425, kSplit = 5, kNear = 1.6;
  if (q >= -kCentral && q <= kCentral) {
    const double r = kCentral * kCentral - q * q;
    return q * calc_polynomial(kA, r) / calc_polynomial(kB, r);
  }
  const double r = std::sqrt(-calc_log(q < 0 ? p : 1 - p));
  const double size = r <= kSplit ? calc_polynomial(kC, r - kNear) / calc_polynomial(kD, r - kNear)
                                  : calc_polynomial(kE, r - kSplit) / calc_polynomial(kF, r - kSplit);
  return q < 0 ? -size : size;
}

}  // namespace unlatch::hil
