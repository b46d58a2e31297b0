// Forces of elements between two bodies, added to those in an evaluation: each on the follower, and its opposite on the
// base. Nothing can push the ground. World axes.
#pragma once

#include "kernel/joints/kinematics.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// On one body, at its origin; N, N m.
inline void push(Evaluation& ev, int body, const Vec3& force, const Vec3& torque) {
  if (body != kGround) add(ev.blocks.data(), ev.places[at(body)], &SharedLane::force, {force, torque});
}

// A force at arms from the bodies' origins, N, m.
inline void push_apart(Evaluation& ev, int base, int follower, const Vec3& r_base, const Vec3& r_follower,
                       const Vec3& force) {
  push(ev, follower, force, cross(r_follower, force));
  push(ev, base, -force, -cross(r_base, force));
}

// A torque, N m.
inline void turn_apart(Evaluation& ev, int base, int follower, const Vec3& torque) {
  push(ev, follower, {0, 0, 0}, torque);
  push(ev, base, {0, 0, 0}, -torque);
}

}  // namespace unlatch
