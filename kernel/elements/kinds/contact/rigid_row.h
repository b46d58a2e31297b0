// Rows of rigid contacts: a pair of shapes that is closed keeps its distance at zero, by a force that can only push.
//
// One shape of a pair is a sphere, the other convex or a half-space. Seen from the other body O, the sphere's centre x
// moves with u = v_x − v_O(x), the velocity of O's material there, and the gap φ between the surfaces has
//
//   φ' = n·u,   φ'' = n·(a_x − a_O(x) − 2 w_O × u) + u·(dn/dx) u,
//
// n the normal from O to the sphere, a_O(x) the acceleration of O's material at x, dn/dx the surface's curvature there
// (kernel/geometry/distance.h). The bodies' accelerations enter through the row's wrenches ±n at x alone; the
// rest is the row's bias. The unit force n at x goes through the point of contact, since x lies on the normal there.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/geometry/distance.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {

// Most pairs of shapes of all rigid contacts of a model: their rows are solved by a dense matrix.
inline constexpr int kMostRigidPairs = 64;
// m: a rigid pair that begins this near to a touch begins closed, unless it approaches or parts.
inline constexpr double kRigidStart = 1e-9;
// m/s: slower than this along the normal is at rest there.
inline constexpr double kRigidRest = 1e-9;

// False if the sphere's centre has got into the other shape: the row is of no use then.
[[nodiscard]] bool calc_rigid_row(const PlanData& plan, std::int32_t pair, const BodyFrame& base,
                                  const BodyFrame& follower, RigidRow& row) noexcept;

// Sum of what two bodies' accelerations, velocities or displacements do to the gap.
inline double apply_rigid_row(const RigidRow& row, const Spatial& base, const Spatial& follower) {
  return dot(row.on_base, base) + dot(row.on_follower, follower);
}

// Collects the rows of the closed pairs of rigid contacts that are on, in the order of the pairs, at the kinematics in
// `ev`. Returns kNone, or the pair whose row is of no use.
std::int32_t collect_rigid_rows(const PlanData& plan, const State& state, double t, Evaluation& ev) noexcept;

// The forces of an evaluation become those of its state.
void store_rigid_forces(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

}  // namespace unlatch
