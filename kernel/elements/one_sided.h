// One-sided forces at one stage: pushers, stops and cords, see OneSided in unlatch/model.h. Which of them are engaged
// is the state's, and changes at events alone; between these the law is smooth, so that stages on either side of a
// limit see one law.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/joints/joint_motion.h"
#include "kernel/model/one_sided_law.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Its coordinate, and how a unit of force along it acts on the two bodies. World axes.
struct OneSidedMotion {
  Vec3 direction;           // along which the coordinate grows; of an angle, its axis; 0 where the line has no length
  Vec3 r_base, r_follower;  // from the bodies' origins to where it acts
  double x, depth, depth_rate;  // coordinate, m or rad; depth and its rate
  CordPath path{};              // of a cord with a drum
};

// Needs kinematics, joint frames and coordinates.
OneSidedMotion calc_motion(const PlanData& plan, const State& state, const Evaluation& ev,
                           const PlanOneSided& own) noexcept;
// The law of one in the plan.
OneSidedLaw get_law(const PlanData& plan, const PlanOneSided& own) noexcept;

// It is switched on, or about to be by a ramp.
bool is_on(const ElementState& element, double t) noexcept;
// Its force, N or N m: 0 if it is not engaged.
double calc_force(const PlanData& plan, const State& state, double t, const PlanOneSided& own,
                  const OneSidedMotion& motion) noexcept;
// Depth times a stiffness, or the force, whichever is less, N or N m: engaged from where it comes to 0 until it falls
// below.
double calc_reach(const PlanData& plan, const PlanOneSided& own, const OneSidedMotion& motion) noexcept;
// The depth is the less of the two numbers that calc_reach() compares: a force that is not engaged is then beyond its
// limit or, but for rounding, at it. Otherwise it is within its limit, and its force is 0.
bool ends_with_depth(const PlanData& plan, const PlanOneSided& own, const OneSidedMotion& motion) noexcept;

// The bearings of cords' ends on their drums: counts them on from those in the state, which they replace.
void store_bearings(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

// Adds their forces to the bodies'.
void add_one_sided_forces(const Instant& now, Evaluation& ev) noexcept;

}  // namespace unlatch
