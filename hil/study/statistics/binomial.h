// Binomial counts and the beta distribution that belongs to them, by Boost.Math. Its headers are slow to compile: only
// binomial.cc includes them. The last digits may differ from machine to machine; nothing that a run computes uses them.
#pragma once

#include <cstdint>

namespace unlatch::hil {

// Least k with P(X ≤ k) ≥ `probability`, of a count of `trials` with the probability p each.
std::int64_t calc_binomial_quantile(double probability, std::int64_t trials, double p);
// The probability of a count with P(X ≤ k) = `tail`, and the one with P(X ≥ k) = `tail` (Clopper and Pearson 1934).
double calc_upper_bound(std::int64_t k, std::int64_t trials, double tail);
double calc_lower_bound(std::int64_t k, std::int64_t trials, double tail);

// Finds x with I_x(a, b) = p, the regularised incomplete beta function.
double calc_beta_quantile(double a, double b, double p);
// Finds x with P(X ≤ x) = p, of Student's t with so many degrees of freedom.
double calc_student_quantile(double freedom, double p);

}  // namespace unlatch::hil
