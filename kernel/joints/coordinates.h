// Coordinates of joints that springs, guards and sensors read: displacements along the joint frame's axes, angles about
// the rotation frame's, turns counted, and their rates.
#pragma once

#include "kernel/plan/evaluation.h"
#include "unlatch/motion.h"  // calc_twist

namespace unlatch {

// The coordinates that are computed.
enum class CoordinateSet {
  kDriven,  // those that springs read: every stage needs them
  kAll,
};

// Gradient of a joint's angle, W: dθ/dt = g · w_rel, so that a torque τ g does the work τ dθ. The angle about an axis n
// of the base is the twist of the follower's attitude about it: of all turns about n the nearest to the attitude. With
// n_f, the axis n that the follower carries, g = (n + n_f) / (1 + n · n_f): the axis itself while the other rotations
// are held. Where the follower's axis is opposite to the base's, there is no twist, and n is returned.
Vec3 calc_angle_gradient(const PlanData& plan, const State& state, const Evaluation& ev,
                         const PlanCoordinate& coordinate) noexcept;

// From the joints' frames: ev.speeds, ev.coordinates of displacements, and of rotations ev.rotation_sines and
// ev.rotation_cosines, padded to whole packs of eight. Returns the number of rotations.
std::size_t measure_coordinates(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept;
// ev.coordinates of rotations: the angles that stand in ev.rotation_sines, turns counted from those in the state's
// joints.
void unwind_angles(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept;

}  // namespace unlatch
