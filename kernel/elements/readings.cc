#include "unlatch/readings.h"

#include <algorithm>

#include "kernel/elements/element_reading.h"
#include "kernel/elements/one_sided.h"
#include "kernel/elements/springs.h"
#include "kernel/model/from_eigen.h"

namespace unlatch {
namespace {

// The first of `elements` numbers elements of one kind in a row.
template <class Elements>
const auto* find(const Elements& elements, int element) {
  const std::size_t first = elements.empty() ? 0 : at(elements[0].element), i = at(element);
  return i >= first && i < first + elements.size() ? &elements[i - first] : nullptr;
}

}  // namespace

SpringReading calc_point_spring(const Plan& plan, const State& state, int spring) noexcept {
  const PlanPointSpring& own = plan.data().point_springs[at(spring)];
  const double scale = calc_scale(state.elements[at(own.element)], plan.data().get_time(state.header->tick));
  const PointSpringForce f =
      calc_force(own, calc_body_frame(state, own.base), calc_body_frame(state, own.follower), scale);
  return {f.length, scale == 0 ? 0 : f.size, scale};
}

PointSpringForce calc_point_spring(const PointSpring& spring, const BodyState& base, const BodyState& follower,
                                   double scale) noexcept {
  const PlanPointSpring own{spring.base,
                            spring.follower,
                            kNone,
                            spring.push_only,
                            to_vec(spring.point_base),
                            to_vec(spring.point_follower),
                            spring.stiffness,
                            spring.damping,
                            spring.free_length};
  return calc_force(own, calc_body_frame(base), calc_body_frame(follower), scale);
}

PlaneTorsionForce calc_plane_torsion(const PlaneTorsion& torsion, const BodyState& base, const BodyState& follower,
                                     double scale) noexcept {
  const PlanPlaneTorsion own{
      torsion.base,      torsion.follower, kNone, to_vec(torsion.normal_base), to_vec(torsion.axis_follower),
      torsion.stiffness, torsion.damping};
  return calc_force(own, calc_body_frame(base), calc_body_frame(follower), scale);
}

namespace {

// `get_frame`: of a body by its number; `read_one_sided`: reading of a one-sided force.
template <class GetFrame, class ReadOneSided>
ElementReading read_element(const PlanData& plan, const State& state, double t, const Evaluation& ev, int element,
                            const GetFrame& get_frame, const ReadOneSided& read_one_sided) noexcept {
  ElementReading out;
  out.scale = calc_scale(state.elements[at(element)], t);
  if (const PlanLoad* const load = find(plan.loads, element)) {
    out.force = ev.load_sizes[at(element) - at(plan.loads[0].element)] * load->length;
  } else if (const PlanPointSpring* const spring = find(plan.point_springs, element)) {
    const PointSpringForce f = calc_force(*spring, get_frame(spring->base), get_frame(spring->follower), out.scale);
    out = {f.size, f.length, f.rate, out.scale, spring->free_length - f.length};
  } else if (const PlanJointSpring* const joint = find(plan.joint_springs, element)) {
    out.length = ev.coordinates[at(joint->coordinate)];
    out.rate = ev.speeds[at(joint->coordinate)];
    out.force = calc_joint_spring(*joint, out.length, out.rate, out.scale);
  } else if (const PlanPlaneTorsion* const torsion = find(plan.plane_torsions, element)) {
    const PlaneTorsionForce f = calc_force(*torsion, get_frame(torsion->base), get_frame(torsion->follower), out.scale);
    out = {f.size, f.angle, f.rate, out.scale};
  } else if (const PlanOneSided* const force = find(plan.one_sided, element)) {
    const OneSidedReading f = read_one_sided(*force);
    out = {force->sign * f.force, f.coordinate, -force->sign * f.depth_rate, out.scale, f.depth, f.wound, f.on_drum};
  } else if (const PlanFriction* const friction = find(plan.frictions, element)) {
    out.length = ev.coordinates[at(friction->coordinate)];
    out.rate = ev.speeds[at(friction->coordinate)];
    out.force = ev.friction_sizes[at(element) - at(plan.frictions[0].element)];
  }
  return out;
}

}  // namespace

ElementReading calc_element(const Instant& now, const Evaluation& ev, int element) noexcept {
  return read_element(
      now.plan, now.state, now.t, ev, element, [&](int body) { return get_body_frame(ev, body); },
      [&](const PlanOneSided& own) {
        const OneSidedMotion m = calc_motion(now.plan, now.state, ev, own);
        return OneSidedReading{.coordinate = m.x,
                               .depth = m.depth,
                               .depth_rate = m.depth_rate,
                               .force = calc_force(now.plan, now.state, now.t, own, m),
                               .wound = std::max(0.0, m.path.winding),
                               .on_drum = m.path.on_drum,
                               .bearing = m.path.bearing};
      });
}

ElementReading calc_element(const Plan& owner, const State& state, const Workspace& workspace, int element) noexcept {
  const PlanData& plan = owner.data();
  const Evaluation& ev = workspace.data().kept.evaluation;
  return read_element(
      plan, state, plan.get_time(state.header->tick), ev, element,
      [&](int body) { return calc_body_frame(state, body); },
      [&](const PlanOneSided& own) { return calc_one_sided(owner, state, workspace, own.number); });
}

std::span<const double> get_modal_rates(const Plan& plan, const State& state, int body) noexcept {
  const std::span<const double> own = get_modal_coordinates(plan, state, body);
  return own.empty() ? own : std::span<const double>(own.data() + own.size(), own.size());
}

}  // namespace unlatch
