#include "kernel/elements/kinds/one_sided/one_sided.h"

#include <algorithm>

#include "kernel/joints/coordinates.h"
#include "kernel/joints/kinematics.h"
#include "unlatch/readings.h"

namespace unlatch {
namespace {

// Coordinate, depth and depth rate of a one-sided force in a joint; direction and arms stay 0.
OneSidedMotion calc_joint_depth(const Evaluation& ev, const PlanOneSided& own) {
  OneSidedMotion m{};
  m.x = ev.coordinates[at(own.coordinate)];
  m.depth = own.sign * (own.limit - m.x);
  m.depth_rate = -own.sign * ev.speeds[at(own.coordinate)];
  return m;
}

OneSidedMotion calc_joint_motion(const PlanData& plan, const State& state, const Evaluation& ev,
                                 const PlanOneSided& own) {
  const JointView joint(plan, ev, own.joint);
  OneSidedMotion m = calc_joint_depth(ev, own);
  m.direction = own.axis < kRotX ? joint.get_axis(own.axis)
                                 : calc_angle_gradient(plan, state, ev, plan.coordinates[at(own.coordinate)]);
  m.r_base = joint.get_arm(false);
  m.r_follower = joint.get_arm(true);
  return m;
}

// Between points of two bodies.
OneSidedMotion calc_point_motion(const PlanData& plan, const State& state, const PlanOneSided& own,
                                 const BodyFrame& base, const BodyFrame& follower) {
  if (own.drum == kNone) return calc_point_motion(own, nullptr, 0, base, follower);
  return calc_point_motion(own, &plan.drums[at(own.drum)], state.bearings[at(own.drum)], base, follower);
}

// A stiffness that makes depths comparable with forces, so that the lesser of both has no corner near its crossing,
// where an event is searched: that of the law, or its force over its stroke. N/m or N m/rad.
double get_scale(const OneSidedLaw& law) {
  double scale = law.stiffness;
  if (law.kind == OneSided::Law::kGas) scale = law.preload / law.gas_length;
  if (law.kind == OneSided::Law::kTable && law.stroke > 0) scale = law.forces.front() / law.stroke;
  if (law.kind == OneSided::Law::kLinear && scale == 0 && law.stroke > 0) scale = law.preload / law.stroke;
  return scale > 0 ? scale : 1;
}

}  // namespace

OneSidedMotion calc_point_motion(const PlanOneSided& own, const CordDrum* drum, double bearing, const BodyFrame& base,
                                 const BodyFrame& follower) noexcept {
  OneSidedMotion m{};
  m.r_follower = follower.R * own.point_follower;
  const Vec3 from_base = (follower.p + m.r_follower) - base.p;
  if (drum != nullptr) {  // the pull's line passes through the end, where its moments are the same as at the drum
    m.path = calc_cord_path(*drum, base.R, from_base, bearing);
    m.direction = m.path.direction;
    m.r_base = from_base;
    m.x = m.path.length;
  } else if (own.guided) {  // the force acts on the base where the follower's point is
    m.direction = base.R * own.guide;
    m.r_base = from_base;
    m.x = dot(m.direction, from_base - base.R * own.point_base);
  } else {
    m.r_base = base.R * own.point_base;
    const PointLine line = calc_line(from_base - m.r_base);
    m.x = line.length;
    m.direction = line.direction;
  }
  const Vec3 v = (follower.v + cross(follower.w, m.r_follower)) - (base.v + cross(base.w, m.r_base));
  m.depth = own.sign * (own.limit - m.x);
  m.depth_rate = -own.sign * dot(m.direction, v);
  return m;
}

OneSidedMotion calc_motion(const PlanData& plan, const State& state, const Evaluation& ev,
                           const PlanOneSided& own) noexcept {
  if (own.joint != kNone) return calc_joint_motion(plan, state, ev, own);
  return calc_point_motion(plan, state, own, get_body_frame(ev, own.base), get_body_frame(ev, own.follower));
}

OneSidedMotion calc_motion(const FinalMotion& motion, const PlanOneSided& own) noexcept {
  if (own.joint != kNone) return calc_joint_depth(motion.ev, own);
  return calc_point_motion(motion.plan(), motion.state(), own, motion.get_frame(own.base),
                           motion.get_frame(own.follower));
}

ElementEnergy OneSidedKind::calc_energy(const StageMotion& motion, const PlanOneSided& own, const Effort& effort,
                                        double scale) {
  const OneSidedMotion m = calc_motion(motion, own);
  if (motion.state().engaged[at(own.number)] == 0 && ends_with_depth(motion.plan(), own, m)) return {};
  const OneSidedLaw law = get_law(motion.plan(), own);
  const double force = own.sign * effort.size;
  return {.potential = calc_stored_energy(law, std::max(0.0, m.depth)),
          .dampers = (scale * calc_elastic_force(law, m.depth) - force) * m.depth_rate};
}

void store_bearings(const PlanData& plan, const Evaluation& ev, State& state) noexcept {
  if (plan.drums.empty()) return;
  for (const PlanOneSided& own : plan.one_sided)
    if (own.drum != kNone) state.bearings[at(own.drum)] = calc_motion(plan, state, ev, own).path.bearing;
}

OneSidedLaw get_law(const PlanData& plan, const PlanOneSided& own) noexcept {
  return {own.law, plan.travels.subspan(at(own.first), at(own.count)),
          plan.travel_forces.subspan(at(own.first), at(own.count))};
}

bool is_on(const ElementState& element, double t) noexcept { return element.to != 0 || calc_scale(element, t) != 0; }

double calc_force(const PlanData& plan, const State& state, double t, const PlanOneSided& own,
                  const OneSidedMotion& motion) noexcept {
  if (state.engaged[at(own.number)] == 0) return 0;
  const double scale = calc_scale(state.elements[at(own.element)], t);
  if (scale == 0) return 0;
  return scale * std::max(0.0, calc_sum(get_law(plan, own), motion.depth, motion.depth_rate));
}

double calc_reach(const PlanData& plan, const PlanOneSided& own, const OneSidedMotion& motion) noexcept {
  const OneSidedLaw law = get_law(plan, own);
  const double depth = get_scale(law) * motion.depth, force = calc_sum(law, motion.depth, motion.depth_rate);
  return force == 0 ? depth : std::min(depth, force);
}

bool ends_with_depth(const PlanData& plan, const PlanOneSided& own, const OneSidedMotion& motion) noexcept {
  const OneSidedLaw law = get_law(plan, own);
  return motion.depth <= 0 || get_scale(law) * motion.depth < calc_sum(law, motion.depth, motion.depth_rate);
}

OneSidedReading calc_one_sided(const Plan& owner, const Workspace& workspace, int number) noexcept {
  const PlanData& plan = get_data(owner);
  const State& state = get_data(workspace).kept.state;
  const PlanOneSided& own = plan.one_sided[at(number)];
  const double t = plan.get_time(state.header->tick);
  const OneSidedMotion m = calc_motion(FinalMotion{plan, get_data(workspace).kept}, own);
  return {m.x,
          m.depth,
          m.depth_rate,
          calc_force(plan, state, t, own, m),
          calc_scale(state.elements[at(own.element)], t),
          std::max(0.0, m.path.winding),
          m.path.on_drum,
          m.path.bearing};
}

double calc_one_sided_force(const OneSided& force, double depth, double depth_rate) noexcept {
  return std::max(0.0, calc_sum(get_law(force), depth, depth_rate));
}

double calc_one_sided_energy(const OneSided& force, double depth) noexcept {
  return depth > 0 ? calc_stored_energy(get_law(force), depth) : 0;
}

}  // namespace unlatch
