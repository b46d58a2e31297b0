#include "kernel/elements/compliance.h"

#include <algorithm>

#include "kernel/elements/kinds/load.h"

namespace unlatch {

bool is_stiff(const PlanData& plan, const State& state, double t) noexcept {
  for (const PlanFlexible& body : plan.flexible)
    if (body.implicit) return true;
  return std::any_of(plan.compliant.begin(), plan.compliant.end(), [&](const PlanCompliant& c) {
    return calc_scale(state.elements[at(plan.joint_springs[at(c.spring)].element)], t) != 0;
  });
}

Implicit begin_compliance(const PlanData& plan, const State& state, double t, double h, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (const PlanCompliant& c : plan.compliant) c.pivot.in(blocks) = 0;
  for (std::size_t i = 0; i < plan.compliant.size(); ++i) {
    const PlanCompliant& c = plan.compliant[i];
    const PlanJointSpring& spring = plan.joint_springs[at(c.spring)];
    const double scale = calc_scale(state.elements[at(spring.element)], t + 0.5 * h);
    ev.compliant[i] = {scale * spring.stiffness, scale * spring.damping, 0, 0, 0, 0};
    const CompliantSpring& own = ev.compliant[i];
    c.pivot.in(blocks) += calc_implicit_pivot(own.stiffness, own.damping, kGamma * h);  // several may share a freedom
  }
  return {ImplicitStage::kFirst, h, kGamma * h};
}

Implicit begin_second_stage(const PlanData& plan, const Implicit& first, Evaluation& ev) noexcept {
  for (std::size_t i = 0; i < plan.compliant.size(); ++i) {
    const PlanCompliant& c = plan.compliant[i];
    const PlanJointSpring& spring = plan.joint_springs[at(c.spring)];
    CompliantSpring& kept = ev.compliant[i];
    kept.first_acceleration = c.side * c.acceleration.in(ev.blocks.data());
    const std::size_t coordinate = at(spring.coordinate);
    kept.first_rate = ev.speeds[coordinate] + first.gamma_h * kept.first_acceleration;
    kept.second_place = ev.coordinates[coordinate] + first.h * kept.first_rate;
    kept.second_rate = ev.speeds[coordinate] + first.h * kept.first_acceleration;
  }
  return {ImplicitStage::kSecond, first.h, first.gamma_h};
}

double calc_lead(const CompliantSpring& spring, const Implicit& implicit, double& x, double& rate) noexcept {
  const double gamma_h = implicit.gamma_h;
  switch (implicit.stage) {
    case ImplicitStage::kOff:
      return 0;
    case ImplicitStage::kFirst:
      return calc_first_lead(spring.stiffness, rate, gamma_h);
    case ImplicitStage::kSecond:
      x = spring.second_place;
      rate = spring.second_rate;
      return calc_second_lead(spring.stiffness, spring.damping, rate, spring.first_rate, spring.first_acceleration,
                              gamma_h);
  }
  return 0;
}

}  // namespace unlatch
