// Motion of the bodies as a function of time, from the knots of the latest steps: between two knots position and
// attitude by quintic Hermite interpolation (values, rates and accelerations at both ends; the error is of order h⁶),
// velocity and angular velocity by cubic ones (h⁴). At the knots it is the state itself.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "unlatch/motion.h"

namespace unlatch::hil {

// A smooth piece of motion between two knots, kept by the window that it is of.
struct MotionPiece {
  double from = 0, to = 0;                        // s
  std::span<const BodyState> start{}, end{};      // by body
  std::span<const Spatial> at_start{}, at_end{};  // accelerations of the origins, world axes
  // Pose and velocity at a time between the two.
  [[nodiscard]] BodyState calc_body(std::size_t body, double time) const;
};

// The present piece and the one before it.
class MotionWindow {
 public:
  MotionWindow() = default;
  MotionWindow(const MotionWindow&) = delete;
  MotionWindow& operator=(const MotionWindow&) = delete;

  // Goes on to the piece between two knots.
  void move_on(const MotionKnot& from, const MotionKnot& to);

  // The motion goes on smoothly from the piece before to the present one.
  [[nodiscard]] bool is_smooth() const { return smooth_; }
  [[nodiscard]] const MotionPiece& get_previous() const { return pieces_[1 - present_]; }
  [[nodiscard]] const MotionPiece& get_present() const { return pieces_[present_]; }
  // At a time within the two pieces.
  [[nodiscard]] BodyState calc_body(int body, double time) const;

 private:
  // The bodies at a knot.
  struct Place {
    std::vector<BodyState> bodies;
    std::vector<Spatial> accelerations;
  };
  Place& keep(const MotionKnot& knot);

  std::array<Place, 4> places_;  // ends of the two pieces; where these go on smoothly they share one
  std::size_t next_ = 0;         // of places_: the one that was taken longest ago
  MotionPiece pieces_[2];
  int present_ = 0;
  bool smooth_ = false, begun_ = false;
};

// A body that does not move, as the ground.
BodyState get_rest();

}  // namespace unlatch::hil
