// One-sided forces: pushers, stops and cords, see OneSided in unlatch/model/elements.h. The state says which of them
// are engaged, and this changes at events alone. Between events the law is smooth: stages on both sides of a limit
// compute the same law.
#pragma once

#include <algorithm>
#include <limits>

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/elements/kinds/one_sided/cord_path.h"
#include "kernel/joints/joint_motion.h"
#include "kernel/model/check.h"
#include "kernel/model/one_sided_law.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/readings.h"

namespace unlatch {

// Its coordinate, and how a unit of force along it acts on the two bodies. World axes.
struct OneSidedMotion {
  Vec3 direction;  // along which the coordinate grows; of an angle, its gradient; 0 where the line has no length
  Vec3 r_base, r_follower;      // from the bodies' origins to where it acts
  double x, depth, depth_rate;  // coordinate, m or rad; depth and its rate
  CordPath path{};              // of a cord with a drum
};

// Of one between points of two bodies. `drum`: of a cord that has one, else null; `bearing`: of the cord's end, less
// than half a turn from the present one, rad.
OneSidedMotion calc_point_motion(const PlanOneSided& own, const CordDrum* drum, double bearing, const BodyFrame& base,
                                 const BodyFrame& follower) noexcept;
// By the evaluation of an instant.
OneSidedMotion calc_motion(const PlanData& plan, const State& state, const Evaluation& ev,
                           const PlanOneSided& own) noexcept;
inline OneSidedMotion calc_motion(const StageMotion& motion, const PlanOneSided& own) noexcept {
  return calc_motion(motion.plan(), motion.state(), motion.ev, own);
}
// Without direction and arms in a joint.
OneSidedMotion calc_motion(const FinalMotion& motion, const PlanOneSided& own) noexcept;
// The law of one in the plan.
OneSidedLaw get_law(const PlanData& plan, const PlanOneSided& own) noexcept;

// True if it is switched on, or a ramp has begun to switch it on.
bool is_on(const ElementState& element, double t) noexcept;
// Its force, N or N m: 0 if it is not engaged.
double calc_force(const PlanData& plan, const State& state, double t, const PlanOneSided& own,
                  const OneSidedMotion& motion) noexcept;
// Depth times a stiffness, or the force, whichever is less, N or N m: it is engaged from where this rises to 0 until it
// falls below 0. Where the force is exactly 0, as on a plateau of its table, the depth alone says how far the end is.
double calc_reach(const PlanData& plan, const PlanOneSided& own, const OneSidedMotion& motion) noexcept;
// True if the depth is the less of the two numbers that calc_reach() compares: a force that is not engaged is then
// beyond its limit or, but for rounding, at it. Otherwise it is within its limit, and its force is 0.
bool ends_with_depth(const PlanData& plan, const PlanOneSided& own, const OneSidedMotion& motion) noexcept;

// The bearings of cords' ends on their drums: counts them on from those in the state, which they replace.
void store_bearings(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

struct OneSidedKind {
  static auto& of(auto& model) { return model.one_sided; }
  static auto& of_plan(auto& plan) { return plan.one_sided; }
  static constexpr bool kHasFriction = true;  // its size depends on a rate by Coulomb's law

  static void list_numbers(const OneSided& f, const auto& add) {
    add(f.kind, f.pulls, f.joint, f.axis, f.base, f.follower, f.point_base, f.point_follower, f.guide, f.limit,
        f.stroke, f.law, f.preload, f.stiffness, f.gas_length, f.exponent, f.travels, f.forces, f.damping, f.friction,
        f.friction_speed, f.on);
    if (f.drum) add(f.drum->centre, f.drum->axis, f.drum->radius, f.drum->left, f.drum->wound);
  }
  static void shift(OneSided& f, const auto& by) {
    by.shift_bodies(f.base, f.follower);
    by.shift_joint(f.joint);
  }
  static bool reads_speed(const OneSided& o) { return o.damping != 0 || o.friction != 0; }
  static ElementTraits describe(const Model& model, const OneSided& f);
  static void validate(const OneSided& force, const Check& check);
  static PlanOneSided compile(const OneSided& force, ElementCompiler& compiler);
  static ElementStart start(const Model& model, const OneSided& force);

  static bool acts(const Instant& now, const Evaluation&, const PlanOneSided& own, std::size_t) {
    return now.state.engaged[at(own.number)] != 0;
  }
  static bool holds_ground(const PlanData&, const State& state, const PlanOneSided& own) {
    return state.engaged[at(own.number)] != 0 && own.base == kGround;
  }
  static Effort calc(const auto& motion, const PlanOneSided& own, std::size_t, double) {
    const OneSidedMotion m = calc_motion(motion, own);
    return {.base = own.base,
            .follower = own.follower,
            .turns = own.joint != kNone && own.axis >= kRotX,
            .acts = true,
            .direction = m.direction,
            .r_base = m.r_base,
            .r_follower = m.r_follower,
            .size = own.sign * calc_force(motion.plan(), motion.state(), motion.time(), own, m),
            .length = m.x,
            .rate = -own.sign * m.depth_rate,
            .stroke = m.depth,
            .wound = std::max(0.0, m.path.winding),
            .on_drum = m.path.on_drum};
  }
  // Its travel, for the corners of its table.
  static void keep(const PlanOneSided& own, const Effort& effort, Evaluation& ev) {
    if (own.count > 0) ev.travels[at(own.number)] = own.law.stroke - effort.stroke;
  }
  static void rest(const PlanOneSided& own, Evaluation& ev) {
    if (own.count > 0) ev.travels[at(own.number)] = std::numeric_limits<double>::quiet_NaN();
  }
  // Energy stored within reach goes into the force or is lost. At the event that ends a push the depth is 0 but for
  // rounding, and the force still acts: the power before the event. After it nothing acts and nothing is lost.
  static ElementEnergy calc_energy(const StageMotion& motion, const PlanOneSided& own, const Effort& effort,
                                   double scale);
  static LinearSpring get_spring(const PlanData& plan, const PlanOneSided& own) {
    return {calc_largest_stiffness(get_law(plan, own)), own.law.damping};
  }
};

}  // namespace unlatch
