// Forces of elements at one stage: loads that keep their direction in the world, springs and dampers, contacts,
// one-sided forces, friction; those of bodies that bend or burn; a planet's gravity. Each body's weight, gyroscopic torque and own
// loads are init_forces()'s (body_motion.h).
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Adds them to the bodies' forces, and sets the rates of what is burnt. Needs kinematics, joint frames, coordinates and
// loads of this stage.
void add_forces(const Instant& now, Evaluation& ev) noexcept;

}  // namespace unlatch
