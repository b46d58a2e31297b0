// How far and how fast the shapes of two bodies move relative to one another: bounds on what a distance changes.
#pragma once

#include <algorithm>

#include "hil/run/motion/motion_window.h"
#include "hil/scenario/shapes/clearance.h"

namespace unlatch::hil {

// A body at a knot.
struct MovingBody {
  geometry::Placement at;
  Vec3 v{0, 0, 0}, w{0, 0, 0};  // of the origin; angular velocity; W axes
  Spatial acceleration{};       // of the origin, W axes
};

inline MovingBody get_moving_body(const BodyState& body, const Spatial& acceleration) {
  const geometry::Placement at = to_placement(body);
  return {at, body.v, at.R_WB * body.w, acceleration};
}

// Bounding sphere of one side of a pair relative to the other side.
struct RelativeMotion {
  Vec3 centre{0, 0, 0};  // m
  Mat3 R = kIdentity3;
  double speed = 0;     // m/s, bound on the speed of its points
  double increase = 0;  // m/s², bound on its points' acceleration, without what follows from rates of rotation
};

inline RelativeMotion calc_relative_motion(const ClearanceMonitor::Reach& reach, const MovingBody& a,
                                           const MovingBody& b) {
  const MovingBody &seen = reach.of_b ? b : a, &from = reach.of_b ? a : b;
  const Vec3 arm = seen.at.R_WB * reach.centre, between = (seen.at.p_WB + arm) - from.at.p_WB;
  const Vec3 turn = seen.w - from.w;
  const Vec3 v = ((seen.v + cross(seen.w, arm)) - from.v) - cross(from.w, between);
  const Vec3 v_rate = ((seen.acceleration.lin + cross(seen.acceleration.ang, arm)) - from.acceleration.lin) -
                      cross(from.acceleration.ang, between);
  const Mat3 &R = from.at.R_WB, &S = seen.at.R_WB;
  return {transpose_times(R, between),
          {transpose_times(R, S.x), transpose_times(R, S.y), transpose_times(R, S.z)},
          norm(v) + reach.bound * norm(turn),
          norm(v_rate) + reach.bound * norm(seen.acceleration.ang - from.acceleration.ang)};
}

// m, how far the shapes move relative to one another within a piece of `h` seconds between the two: the distance at its
// ends differs by no more.
inline double calc_length(const RelativeMotion& from, const RelativeMotion& to, double h) {
  return std::max(from.speed, to.speed) * h + std::max(from.increase, to.increase) * h * h;
}

// m, bound on the change of the distance within a piece of `h` seconds between the two: there the interpolated motion
// departs from the knots by less than twice the greater speed times the step.
inline double calc_path(const RelativeMotion& from, const RelativeMotion& to, double h) {
  return 2 * std::max(from.speed, to.speed) * h + std::max(from.increase, to.increase) * h * h;
}

}  // namespace unlatch::hil
