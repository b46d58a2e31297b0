// Coulomb friction in joints, of the size of the reaction across the axis, see JointFriction in unlatch/model.h.
//
// Force and reaction depend on each other: R = R_0 + R_1 F, F = −μ r |R| v / sqrt(v² + v_s²). An evaluation solves the
// system without friction, which gives R_0, and then kFrictionSweeps times with the friction of the latest R, all by
// one factorisation. So F depends on the instant alone: nothing is kept from stage to stage. Where friction moves no
// reaction (R_1 = 0) the first of these is exact; otherwise each takes the error times μ |R_1|, and what is left of |R|
// is (μ |R_1|)^kFrictionSweeps of the first change. μ |R_1| ≥ 1 is a joint that jams by itself: there rigid bodies with
// Coulomb's law have no answer (Painlevé), and the sweeps do not converge.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

inline constexpr int kFrictionSweeps = 4;

// Some friction is switched on in a joint that holds.
bool has_friction(const Instant& now) noexcept;

// ev.friction_sizes, the force or torque on the follower along its axis: of no reaction, and of the present
// multipliers. Needs coordinates' speeds.
void clear_friction(Evaluation& ev) noexcept;
void update_friction(const Instant& now, Evaluation& ev) noexcept;

// Adds them to the bodies' forces.
void add_friction_forces(const PlanData& plan, Evaluation& ev) noexcept;

}  // namespace unlatch
