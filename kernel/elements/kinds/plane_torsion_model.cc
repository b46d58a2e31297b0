#include <cmath>

#include "kernel/elements/kinds/plane_torsion.h"
#include "kernel/elements/start.h"

namespace unlatch {

void PlaneTorsionKind::validate(const PlaneTorsion& torsion, const Check& check) {
  check.check_ends(torsion.base, torsion.follower);
  check.check_unit("normal", torsion.normal_base);
  check.check_unit("axis", torsion.axis_follower);
  check.check_not_negative("stiffness", torsion.stiffness);
  check.check_not_negative("damping", torsion.damping);
}

PlanPlaneTorsion PlaneTorsionKind::compile(const PlaneTorsion& s, ElementCompiler& compiler) {
  return {s.base,      s.follower, compiler.get_element(), to_vec(s.normal_base), to_vec(s.axis_follower),
          s.stiffness, s.damping};
}

ElementStart PlaneTorsionKind::start(const Model& model, const PlaneTorsion& s) {
  const Effort effort = calc_start_effort<PlaneTorsionKind>(model, s);
  return {.kind = "torsion",
          .length = effort.length,
          .force = effort.size,
          .energy = calc_stored(s.stiffness, effort.length),
          .stroke = std::abs(effort.length)};
}

PlaneTorsionForce calc_plane_torsion(const PlaneTorsion& torsion, const BodyState& base, const BodyState& follower,
                                     double scale) noexcept {
  const PlanPlaneTorsion own{
      torsion.base,      torsion.follower, kNone, to_vec(torsion.normal_base), to_vec(torsion.axis_follower),
      torsion.stiffness, torsion.damping};
  return PlaneTorsionKind::calc_force(own, calc_body_frame(base), calc_body_frame(follower), scale);
}

}  // namespace unlatch
