// Impulse and work of springs over pieces of motion, and the instants at which they cease to act, for elements with two
// ends: point springs, joint springs, pushers, cords and stops.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/run/motion/joint_frame.h"
#include "hil/run/motion/motion_window.h"
#include "unlatch/readings.h"

namespace unlatch::hil {

class SpringWork {
 public:
  // `model`: with its markers placed. `element`: its number in the model. Empty for an element of another kind.
  static std::optional<SpringWork> make(const Model& model, int element);

  [[nodiscard]] int get_base() const { return base_; }
  [[nodiscard]] int get_follower() const { return follower_; }
  [[nodiscard]] int get_element() const { return element_; }
  // True if it is switched on and exerts a force: a pusher until it has its free length.
  [[nodiscard]] bool acts(const MotionKnot& knot) const;
  // Time at which a pusher reaches its free length within the present piece, to 1e-9 of it; nothing if it does not.
  [[nodiscard]] std::optional<double> find_end(const MotionWindow& window, const MotionKnot& from) const;

  struct Sum {
    Vec3 impulse{0, 0, 0};  // impulse of the force on the follower, W, N s; of a torque N m s
    double work = 0;        // J, on both bodies together
  };
  // Impulse and work over the present piece up to `to`, by Simpson's rule.
  [[nodiscard]] Sum calc(const MotionWindow& window, const MotionKnot& from, double to) const;

 private:
  struct Force {
    Vec3 force;    // on the follower, W
    double power;  // W
  };
  // `bearing`: State::bearings of a cord with a drum, at the beginning of the piece.
  [[nodiscard]] Force calc_force(const BodyState& base, const BodyState& follower, double scale, double bearing) const;
  [[nodiscard]] Force calc_one_sided(const BodyState& base, const BodyState& follower, double scale,
                                     double bearing) const;
  [[nodiscard]] double calc_length(const BodyState& base, const BodyState& follower) const;

  int element_ = 0, base_ = kGround, follower_ = 0;
  std::optional<PointSpring> point_;
  std::optional<JointSpring> joint_;
  std::optional<OneSided> one_sided_;
  std::size_t number_ = 0;  // number among the one-sided forces
  double limit_ = 0;        // limit of the coordinate, m or rad
  std::optional<JointGeometry> geometry_;
  std::optional<CordDrum> drum_;
  std::size_t drum_number_ = 0;  // index into State::bearings
};

}  // namespace unlatch::hil
