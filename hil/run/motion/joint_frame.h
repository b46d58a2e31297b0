// Coordinates of a joint from the poses and velocities of its bodies, at any time: displacement and speed of the
// follower's point along the joint frame's axes, angle and its rate about the rotation frame's.
// kernel/joints/coordinates.h has the same at the ends of a step.
#pragma once

#include <vector>

#include "unlatch/model.h"
#include "unlatch/motion.h"

namespace unlatch::hil {

class JointGeometry {
 public:
  // `model`: with its markers placed (place_markers()).
  JointGeometry(const Model& model, int joint);

  [[nodiscard]] int get_base() const { return base_; }
  [[nodiscard]] int get_follower() const { return follower_; }
  // Coordinate and its rate. `row`: Row. m or rad (in (−π, π]); m/s or rad/s.
  [[nodiscard]] double calc_coordinate(const BodyState& base, const BodyState& follower, int row) const;
  [[nodiscard]] double calc_speed(const BodyState& base, const BodyState& follower, int row) const;
  // Axis of a row, world axes.
  [[nodiscard]] Vec3 calc_axis(const BodyState& base, int row) const;

 private:
  int base_, follower_;
  Vec3 p_base_, p_follower_;
  Mat3 axes_, rotation_axes_, follower_axes_;  // in base, base and follower axes
};

}  // namespace unlatch::hil
