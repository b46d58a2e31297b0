#include "kernel/dynamics/compliance.h"

#include <algorithm>

#include "kernel/dynamics/loads.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double calc_pivot(const CompliantSpring& spring, double lead) {
  return lead * (lead * spring.stiffness + spring.damping);
}

}  // namespace

bool is_stiff(const Plan& plan, const State& state, double t) noexcept {
  for (const PlanFlexible& body : plan.flexible)
    if (body.implicit) return true;
  return std::any_of(plan.compliant.begin(), plan.compliant.end(), [&](const PlanCompliant& c) {
    return calc_scale(state.elements[at(plan.joint_springs[at(c.spring)].element)], t) != 0;
  });
}

void begin_compliance(const Plan& plan, const State& state, double t, double h, Workspace& ws) noexcept {
  ws.implicit = {ImplicitStage::kFirst, h, kGamma * h};
  for (const PlanCompliant& c : plan.compliant) ws.lanes[at(c.pivot)] = 0;
  for (std::size_t i = 0; i < plan.compliant.size(); ++i) {
    const PlanCompliant& c = plan.compliant[i];
    const PlanJointSpring& spring = plan.joint_springs[at(c.spring)];
    const double scale = calc_scale(state.elements[at(spring.element)], t + 0.5 * h);
    ws.compliant[i] = {scale * spring.stiffness, scale * spring.damping, 0, 0, 0, 0};
    ws.lanes[at(c.pivot)] += calc_pivot(ws.compliant[i], ws.implicit.lead);  // several may share a freedom
  }
}

void keep_first_stage(const Plan& plan, Workspace& ws) noexcept {
  ws.implicit.stage = ImplicitStage::kSecond;
  for (std::size_t i = 0; i < plan.compliant.size(); ++i) {
    const PlanCompliant& c = plan.compliant[i];
    const PlanJointSpring& spring = plan.joint_springs[at(c.spring)];
    CompliantSpring& kept = ws.compliant[i];
    kept.first_acceleration = c.side * ws.lanes[at(c.acceleration)];
    const std::size_t coordinate = at(spring.coordinate);
    kept.first_rate = ws.speeds[coordinate] + ws.implicit.lead * kept.first_acceleration;
    kept.second_place = ws.coordinates[coordinate] + ws.implicit.h * kept.first_rate;
    kept.second_rate = ws.speeds[coordinate] + ws.implicit.h * kept.first_acceleration;
  }
}

void end_compliance(const Plan& plan, Workspace& ws) noexcept {
  ws.implicit = {};
  for (const PlanCompliant& c : plan.compliant) ws.lanes[at(c.pivot)] = 0;
}

double calc_lead(const CompliantSpring& spring, const Implicit& implicit, double& x, double& rate) noexcept {
  const double lead = implicit.lead;
  switch (implicit.stage) {
    case ImplicitStage::kOff:
      return 0;
    case ImplicitStage::kFirst:
      return -lead * spring.stiffness * rate;
    case ImplicitStage::kSecond:
      x = spring.second_place;
      rate = spring.second_rate;
      return 2 * calc_pivot(spring, lead) * spring.first_acceleration -
             lead * spring.stiffness * (rate - 2 * spring.first_rate);
  }
  return 0;
}

}  // namespace unlatch
