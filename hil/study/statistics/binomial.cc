#include "hil/study/statistics/binomial.h"

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>

namespace unlatch::hil {
namespace {

namespace policies = boost::math::policies;
using Binomial =
    boost::math::binomial_distribution<double,
                                       policies::policy<policies::discrete_quantile<policies::integer_round_up>>>;

}  // namespace

std::int64_t calc_binomial_quantile(double probability, std::int64_t trials, double p) {
  return static_cast<std::int64_t>(quantile(Binomial(static_cast<double>(trials), p), probability));
}

double calc_upper_bound(std::int64_t k, std::int64_t trials, double tail) {
  return Binomial::find_upper_bound_on_p(static_cast<double>(trials), static_cast<double>(k), tail);
}

double calc_lower_bound(std::int64_t k, std::int64_t trials, double tail) {
  return Binomial::find_lower_bound_on_p(static_cast<double>(trials), static_cast<double>(k), tail);
}

double calc_beta_quantile(double a, double b, double p) { return boost::math::ibeta_inv(a, b, p); }

double calc_student_quantile(double freedom, double p) {
  return quantile(boost::math::students_t_distribution<double>(freedom), p);
}

}  // namespace unlatch::hil
