// Rows of rigid contacts: a pair of shapes that is closed keeps its distance at zero, by a force that can only push.
//
// One shape of a pair is a sphere, the other convex or a half-space; or both are capsules. Of a sphere on body S, x is
// the centre, which moves with its material; of a capsule, the place of its axis that is nearest to the other's, which
// moves along the axis as well, with σ: a sphere that slides along it. Seen from the other body O, x moves with u + σ,
// u = v_S(x) − v_O(x) the velocities of the materials there, and the gap φ between the surfaces has
//
//   φ' = n·u,   φ'' = n·(a_S(x) − a_O(x) − 2 w_O × u + (w_S − w_O) × σ) + u·(dn/dx) (u + σ),
//
// n the normal from O to x, a_S(x), a_O(x) the accelerations of the materials at x, dn/dx the surface's curvature there
// (kernel/geometry/distance.h). The bodies' accelerations enter through the row's wrenches ±n at x alone; the
// rest is the row's bias. The unit force n at x goes through the point of contact, since x lies on the normal there.
//
// σ = s' a, a the unit vector along the capsule's axis, keeps n across it: n'·a + n·a' = 0, seen from O, hence
//
//   s' (a·(dn/dx) a) = −a·(dn/dx) u − n·((w_S − w_O) × a).
//
// The factor on the left is sin²/D, of the angle between the axes and the distance D between them. Two axes that are
// parallel have no such place: the row is of no use then. At an end of the axis σ = 0.
//
// Friction. At the place c = x − r n of the sphere's surface the slip is u_c = v_S(c) − v_O(c), r the sphere's radius.
// Its two components along unit vectors t across the normal are rows of their own, with the wrenches ±t at c and
//
//   d(t·u_c)/dt = t·(a_S(c) − a_O(c) + w_S × (c' − v_S(c)) − w_O × (c' − v_O(c))),   c' = v_S(x) + σ − r n',
//
// where the slip is zero, so that t' does not count.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/geometry/distance.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {

// True if a rigid contact can have this pair of shapes.
inline bool has_rigid_row(geometry::ShapeKind a, geometry::ShapeKind b) noexcept {
  using geometry::ShapeKind;
  if (a == ShapeKind::kCapsule && b == ShapeKind::kCapsule) return true;
  return (a == ShapeKind::kSphere && geometry::has_sphere_distance(b)) ||
         (b == ShapeKind::kSphere && geometry::has_sphere_distance(a));
}

// Most rows of all rigid contacts of a model, which are solved by a dense matrix: one for each pair of shapes, two more
// where it has friction.
inline constexpr int kMostRigidRows = 64;
// m: a rigid pair that begins this near to a touch begins closed, unless it approaches or parts.
inline constexpr double kRigidStart = 1e-9;
// m/s: slower than this along the normal is at rest there.
inline constexpr double kRigidRest = 1e-9;

// Values of ContactState::closed of a pair of a rigid contact. Closed: without friction, or it slips; or, with a zero
// State::rigid_slips, it has yet to be found sticking or slipping.
inline constexpr std::int64_t kPairOpen = 0, kPairClosed = 1, kPairLeaves = 2, kPairSticks = 3, kPairCreeps = 4;
// The pair is closed and does not leave at this instant.
inline bool is_held(const ContactState& pair) { return pair.closed != kPairOpen && pair.closed != kPairLeaves; }

// False if the row is of no use: the sphere's centre has got into the other shape, an axis of a capsule meets the
// other, or both are parallel (their angle is below 1e-3).
[[nodiscard]] bool calc_rigid_row(const PlanData& plan, std::int32_t pair, const BodyFrame& base,
                                  const BodyFrame& follower, RigidRow& row) noexcept;

// The rows of a pair with friction: that along the normal, which calc_rigid_row() has computed, and the two across it
// in rows[1] and rows[2], the first along `reference`, State::rigid_slips, if that is not zero.
void calc_slip_rows(const PlanData& plan, const ContactState& state, const Vec3& reference, const BodyFrame& base,
                    const BodyFrame& follower, RigidRow* rows) noexcept;

// Sum of what two bodies' accelerations, velocities or displacements do to the gap.
inline double apply_rigid_row(const RigidRow& row, const Spatial& base, const Spatial& follower) {
  return dot(row.on_base, base) + dot(row.on_follower, follower);
}

// Collects the rows of the closed pairs of rigid contacts that are on, in the order of the pairs, at the kinematics in
// `ev`. False if a row is of no use; its contact is noted as what failed.
[[nodiscard]] bool collect_rigid_rows(const PlanData& plan, const State& state, double t, Evaluation& ev) noexcept;

// Of a pair with friction, by the latest evaluation: the acceleration of its slip, m/s²; and that or what its friction
// alone would be, if that is more.
double calc_slip_acceleration(const Evaluation& ev, const RigidRow* rows) noexcept;
double calc_slip_braking(const Evaluation& ev, const RigidRow* rows) noexcept;
// The slip below which it has no direction of its own, m/s: what the finest part of a step changes it by, twice.
double calc_least_slip(const PlanData& plan, double change) noexcept;

// The forces of an evaluation become those of its state.
void store_rigid_forces(const PlanData& plan, const Evaluation& ev, State& state) noexcept;

}  // namespace unlatch
