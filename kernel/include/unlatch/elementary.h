// Elementary functions that give the same bits on every compiler, optimisation level and processor. The C library's do
// not: glibc picks fused multiply-add variants by the processor it finds.
//
// Only IEEE 754 additions, multiplications and divisions of doubles in a fixed order, and 64-bit integer arithmetic; no
// tables but constants of mathematics, no loops, no state. Needs round-to-nearest and -ffp-contract=off.
//
//   function  range of the argument                method                                              largest error
//   sin, cos  all finite                           2/pi to 1216 bits (Payne and Hanek 1983), Taylor    0.80 ulp
//   exp       all; overflows to +inf, underflows   Cody and Waite 1980, two-part ln 2, Taylor          0.80 ulp
//             gradually to +0
//   log       normal numbers > 0                   exponent, 2 atanh((m − 1)/(m + 1)) by its series    2 ulp
//   atan2     all quadrants, signed zeros, inf     table of atan(k/8), double-double quotient          0.56 ulp
//
// (measured against MPFR: tests/kernel/elementary_test.cc). NaN, and the sine of an infinity, give the quiet NaN with a
// zero payload. Cost on a 3 GHz x86-64: 15–27 ns each.
#pragma once

namespace unlatch::elementary {

double sin(double x) noexcept;  // x in rad
double cos(double x) noexcept;  // x in rad
// Sine and cosine of x, rad.
void sincos(double x, double& sine, double& cosine) noexcept;

// e to the power x.
double exp(double x) noexcept;

// Natural logarithm of a finite x > 0 that is a normal number; NaN for any other.
double log(double x) noexcept;

double atan2(double y, double x) noexcept;  // angle of the point (x, y), rad, in [−pi, pi]

}  // namespace unlatch::elementary
