#include "kernel/joints/coordinates.h"

#include "kernel/joints/kinematics.h"
#include "kernel/math/angles.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// Sine and cosine, times one number, of the turn by which the follower's pair of axes stands from the base's.
struct Turn {
  double sine, cosine;
};
UNLATCH_INLINE Turn calc_turn(const Vec3& bi, const Vec3& bj, const Vec3& fi, const Vec3& fj) {
  return {dot(bj, fi) - dot(bi, fj), dot(bi, fi) + dot(bj, fj)};
}

// The turn about a rotation's axis, from the two axes of each side across it.
UNLATCH_INLINE Turn measure_turn(const PlanData& plan, const State& state, const Evaluation& ev,
                                 const PlanCoordinate& c, const JointView& joint) {
  const PlanJoint& j = joint.get_joint();
  const Mat3 follower = read(ev.blocks.data(), ev.places[at(j.follower)], &BodyLane::R);
  const Vec3 fi = follower * c.across_follower[0], fj = follower * c.across_follower[1];
  if (!j.universal || !is_crossed(j, get_active_rows(plan, state, c.joint))) {
    const int k = c.row - kRotX;
    return calc_turn(joint.get_axis(kRotX + (k == 2 ? 0 : k + 1)), joint.get_axis(kRotX + (k == 0 ? 2 : k - 1)), fi,
                     fj);
  }
  const Mat3 base = get_body_frame(ev, j.base).R;  // the cross has turned the joint's own
  return calc_turn(base * c.across_base[0], base * c.across_base[1], fi, fj);
}

std::span<const PlanCoordinate> get_coordinates(const PlanData& plan, CoordinateSet set) {
  return std::span(plan.coordinates)
      .first(set == CoordinateSet::kAll ? plan.coordinates.size() : at(plan.driven_coordinates));
}

// Of 1 + n · n_f, below which an angle is not determined.
constexpr double kLeastTwist = 1e-9;

}  // namespace

Vec3 calc_angle_gradient(const PlanData& plan, const State& state, const Evaluation& ev,
                         const PlanCoordinate& coordinate) noexcept {
  const JointView joint(plan, ev, coordinate.joint);
  const PlanJoint& own = joint.get_joint();
  const Vec3 axis = joint.get_axis(coordinate.row);
  if (has_plain_angle(own, get_active_rows(plan, state, coordinate.joint), coordinate.row)) return axis;
  const Mat3 follower = read(ev.blocks.data(), ev.places[at(own.follower)], &BodyLane::R);
  const Vec3 carried = follower * cross(coordinate.across_follower[0], coordinate.across_follower[1]);
  const double sum = 1 + dot(axis, carried);
  return sum > kLeastTwist ? (1 / sum) * (axis + carried) : axis;
}

double calc_twist(const Mat3& base, const Mat3& follower, int k) noexcept {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  const Turn turn = calc_turn(column(base, i), column(base, j), column(follower, i), column(follower, j));
  return elementary::atan2(turn.sine, turn.cosine);
}

std::size_t measure_coordinates(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept {
  const std::span<const PlanCoordinate> coordinates = get_coordinates(plan, set);
  std::size_t rotations = 0;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const PlanCoordinate& c = coordinates[i];
    const JointView joint(plan, ev, c.joint);
    if (c.row < kRotX) {
      ev.speeds[i] = dot(joint.get_axis(c.row), joint.get_slip().lin);
      ev.coordinates[i] = joint.get_displacement(c.row);
      continue;
    }
    ev.speeds[i] = dot(calc_angle_gradient(plan, state, ev, c), joint.get_slip().ang);
    const Turn turn = measure_turn(plan, state, ev, c, joint);
    ev.rotation_sines[rotations] = turn.sine;
    ev.rotation_cosines[rotations++] = turn.cosine;
  }
  for (std::size_t i = rotations; i % kEight != 0; ++i) {  // whole packs
    ev.rotation_sines[i] = 0;
    ev.rotation_cosines[i] = 1;
  }
  return rotations;
}

void unwind_angles(const PlanData& plan, const State& state, CoordinateSet set, Evaluation& ev) noexcept {
  const std::span<const PlanCoordinate> coordinates = get_coordinates(plan, set);
  std::size_t rotations = 0;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const PlanCoordinate& c = coordinates[i];
    if (c.row < kRotX) continue;
    const double previous = state.joints[at(c.joint)].angle[c.row - kRotX];
    ev.coordinates[i] = unwind(ev.rotation_sines[rotations++], previous);
  }
}

}  // namespace unlatch
