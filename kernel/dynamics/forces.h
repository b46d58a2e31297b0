// Forces of elements at one stage: loads that keep their direction in the world, springs and dampers, contacts,
// one-sided forces, friction; those of flexible bodies and of bodies with a mass law; a planet's gravity. Each body's
// weight, gyroscopic torque and own loads are computed by init_forces() (body_motion.h).
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Adds them to the bodies' forces, and sets the rates of what is burnt: from all that stands in Evaluation before the
// closed pairs of shapes, which it computes.
void add_forces(const Instant& now, Evaluation& ev) noexcept;

}  // namespace unlatch
