// Motion of the bodies as a function of time, from the knots of the latest steps. Between two knots, position and
// attitude are quintic Hermite interpolations (values, rates and accelerations at both ends; the error is of order h⁶),
// velocity and angular velocity cubic ones (h⁴). At the knots it is the state itself.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "unlatch/motion.h"

namespace unlatch::hil {

// A smooth piece of motion between two knots; its window stores the data.
struct MotionPiece {
  double from = 0, to = 0;                        // s
  std::span<const BodyState> start{}, end{};      // by body; the last is the ground
  std::span<const Spatial> at_start{}, at_end{};  // accelerations of the origins, world axes
  // Pose and velocity at a time between the two.
  [[nodiscard]] BodyState calc_body(std::size_t body, double time) const;
  // Likewise with the velocities by which the pose changes, of order h⁵: of a contact that closes fast, the damping
  // depends on them.
  [[nodiscard]] BodyState calc_moving_body(std::size_t body, double time) const;
};

// The present piece and the one before it.
class MotionWindow {
 public:
  MotionWindow() = default;
  MotionWindow(const MotionWindow&) = delete;
  MotionWindow& operator=(const MotionWindow&) = delete;

  // Moves to the piece between two knots.
  void move_on(const MotionKnot& from, const MotionKnot& to);

  // True if the present piece continues the one before smoothly.
  [[nodiscard]] bool is_smooth() const { return smooth_; }
  // True if readings do so as well: no law that only conditions, sensors and outputs read has a corner there.
  [[nodiscard]] bool has_smooth_readings() const { return smooth_ && smooth_readings_; }
  // True if it begins with the motion and the accelerations with which the one before ended; a law may have a corner
  // there.
  [[nodiscard]] bool is_continuous() const { return continuous_; }
  [[nodiscard]] const MotionPiece& get_previous() const { return pieces_[1 - present_]; }
  [[nodiscard]] const MotionPiece& get_present() const { return pieces_[present_]; }
  // State of a body at a time within the two pieces.
  [[nodiscard]] BodyState calc_body(int body, double time) const;
  [[nodiscard]] BodyState calc_moving_body(int body, double time) const;

 private:
  // States of the bodies at a knot.
  struct Place {
    std::vector<BodyState> bodies;
    std::vector<Spatial> accelerations;
  };
  Place& keep(const MotionKnot& knot);
  // The one of the two in which a time lies.
  [[nodiscard]] const MotionPiece& get_piece(double time) const;

  std::array<Place, 4> places_;  // ends of the two pieces; one place is shared where the motion is smooth
  std::size_t next_ = 0;         // index into places_: the one written longest ago
  MotionPiece pieces_[2];
  int present_ = 0;
  bool smooth_ = false, continuous_ = false, begun_ = false;
  bool smooth_readings_ = false;
  bool corner_ = false, reading_corner_ = false;  // the present piece ends at a corner of the motion, of readings
};

// State of a body at rest, such as the ground.
BodyState get_rest();

}  // namespace unlatch::hil
