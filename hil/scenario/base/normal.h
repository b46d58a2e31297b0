// The normal distribution, and the logarithm, with the same bits on every machine: IEEE additions, multiplications,
// divisions and square roots in a written order, and the kernel's exponential.
#pragma once

namespace unlatch::hil {

// Natural logarithm of x > 0: a Newton step of third order on the kernel's exponential. Error 1 ulp or so.
double calc_log(double x);

// Φ(z): probability of a value below z. Relative error some 1e-14, in the tails too: the series of erf in the middle
// (Marsaglia, Evaluating the normal distribution, J. Stat. Software 11, 2004), a continued fraction outside.
double calc_normal_cdf(double z);

// Φ⁻¹(p), p in (0, 1): PPND16 of Wichura, algorithm AS 241, Applied Statistics 37 (1988). Relative error some 1e-15.
double calc_normal_quantile(double p);

}  // namespace unlatch::hil
