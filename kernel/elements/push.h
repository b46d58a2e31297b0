// Forces of elements between two bodies, added to those in an evaluation: each on the follower, and its opposite on the
// base. Nothing can push the ground. World axes.
#pragma once

#include "kernel/joints/kinematics.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Opposite wrenches on two bodies, at their origins, of a force at arms from these; of a torque. N, m, N m.
struct OppositeWrenches {
  Spatial on_base, on_follower;
};
inline OppositeWrenches calc_wrenches(const Vec3& r_base, const Vec3& r_follower, const Vec3& force) {
  return {{-force, -cross(r_base, force)}, {force, cross(r_follower, force)}};
}
inline OppositeWrenches calc_wrenches(const Vec3& torque) { return {{{0, 0, 0}, -torque}, {{0, 0, 0}, torque}}; }

// On one body, at its origin; N, N m.
inline void push(Evaluation& ev, int body, const Vec3& force, const Vec3& torque) {
  if (body != kGround) add(ev.blocks.data(), ev.places[at(body)], &SharedLane::force, {force, torque});
}

inline void push_apart(Evaluation& ev, int base, int follower, const OppositeWrenches& wrenches) {
  push(ev, follower, wrenches.on_follower.lin, wrenches.on_follower.ang);
  push(ev, base, wrenches.on_base.lin, wrenches.on_base.ang);
}

}  // namespace unlatch
