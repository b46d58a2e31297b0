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

// Which slope of a law in time counts at a knot, where the law has two: the last stage of a step belongs to the piece
// before the knot, everything else to the piece after it.
enum class KnotSide { kBefore, kAfter };

// Masses by the law at `t` and ev.auxiliary.
void update_masses(const PlanData& plan, double t, KnotSide side, Evaluation& ev) noexcept;

// Centres of mass and inertias in world axes, after update_kinematics().
void update_varying_kinematics(const PlanData& plan, Evaluation& ev) noexcept;

// Weight, centrifugal force, jet damping; the gyroscopic torque is there. After the loads, which tell what is burnt.
void add_varying_forces(const PlanData& plan, double t, Evaluation& ev) noexcept;

// The blocks of the solver begin with the inertia about the centre of mass; adds what the mass makes of them.
void add_varying_blocks(const PlanData& plan, Evaluation& ev) noexcept;

}  // namespace unlatch
