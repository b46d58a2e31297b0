#include <cmath>

#include "kernel/elements/kinds/aerodynamics.h"
#include "kernel/model/from_eigen.h"

namespace unlatch {

void AerodynamicsKind::validate(const Aerodynamics& a, const Check& check) {
  check.check_body(a.body, "body");
  if (!check.model.environment.planet || !check.model.environment.atmosphere)
    check.report("there is no air", "environment: {planet: wgs84, atmosphere: us1976}", "type");
  check.check_positive("area", a.area);
  for (int i = 0; i < 3; ++i) check.check_positive("lengths", a.lengths[i]);
  check.check_finite("point", a.point.allFinite());
  for (const AeroTerm& term : a.terms) {
    if (term.law == kNone)
      check.check_finite("coefficients", std::isfinite(term.value));
    else if (!is_index(term.law, check.model.laws.size()))
      check.report("the law of a coefficient does not exist", "the index of one law", "coefficients");
    if (term.rate < kNone || term.rate > 2) check.report("a coefficient counts times no rate", "p, q or r", "damping");
  }
}

PlanAerodynamics AerodynamicsKind::compile(const Aerodynamics& a, ElementCompiler& compiler) {
  std::vector<PlanAeroTerm>& terms = compiler.plan.aero_terms;
  const auto first = static_cast<std::int32_t>(terms.size());
  for (const AeroTerm& term : a.terms) terms.push_back({term.of, term.rate, term.law, term.value});
  const auto number = static_cast<std::int32_t>(compiler.plan.aerodynamics.size());
  return {a.body, compiler.get_element(), number,         first, static_cast<std::int32_t>(a.terms.size()),
          a.area, to_vec(a.lengths),      to_vec(a.point)};
}

}  // namespace unlatch
