// Bodies whose mass, centre of mass and inertia follow a law in time or in what they have burnt. Their origin is fixed
// in the structure; with the centre of mass at c from it and J about the centre of mass, world axes,
//
//   force                    = m (a + α × c + w × (w × c))
//   torque about the origin  = J α + w × J w + c × force
//
// Particles leave with the velocity of the structure where they are; what they do beyond that is the thrust, which is a
// load. So neither dm/dt nor dJ/dt appears (the paper's (2.1)), unless jet damping is asked for: then particles leave
// through an exit at r from the centre of mass, which takes away dJ/dt w − (dm/dt) r × (w × r) of angular momentum
// more.
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/plan.h"

namespace unlatch {

// The piece of a law whose slope is used at a knot: stages of a sub-step, of a law in time the last of them, use that
// before the knot at its end, everything else that after it.
enum class KnotSide { kBefore, kAfter };

// ev.varying, but for the world axes: masses by the law at `t` and ev.auxiliary.now.
void update_masses(const PlanData& plan, double t, KnotSide side, Evaluation& ev) noexcept;

// Centres of mass and inertias in world axes, from ev.varying and the bodies' rotations.
void update_varying_kinematics(const PlanData& plan, Evaluation& ev) noexcept;

// Adds weight, centrifugal force and jet damping to the bodies' forces, from ev.varying and the rate at which loads
// burn, ev.auxiliary.rate. The gyroscopic torque is among the forces with which init_forces() begins.
void add_varying_forces(const PlanData& plan, const Vec3& origin, Evaluation& ev) noexcept;

// Adds the mass to the solver's blocks, which begin with the inertia about the centre of mass.
void add_varying_blocks(const PlanData& plan, Evaluation& ev) noexcept;

}  // namespace unlatch
