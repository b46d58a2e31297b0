// The attitude loop of a core stage: attitude and rate feedback on four vernier chambers that swing along its
// circumference.
//
//   u = - K e - D w     for each body axis; e: rotation vector of the attitude (2 x the quaternion's vector part), w:
//   rate swing1 = u_x + u_y, swing2 = u_x + u_z, swing3 = u_x - u_y, swing4 = u_x - u_z
//
// It holds attitude 0: body axes along the inertial ones. Chamber k is on the side of booster k. The swings are limited
// to the ranges of their channels. The gains K and D, of x and of y and z, are the initial values of channels, which
// the vehicle's catalog states.
#pragma once

#include <array>
#include <string>

#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

class AttitudeLoop {
 public:
  // A vehicle without the channel swing1 has no such loop. Returns the names of what is missing, in words; empty if
  // nothing is.
  [[nodiscard]] std::string attach(const Vehicle& vehicle);
  // Commands the chambers whose swing changes.
  void update(const Vehicle& vehicle, Commands& commands);

 private:
  struct Gains {
    double attitude = 0;  // rad/rad
    double rate = 0;      // s
  };
  struct Chamber {
    int channel;
    double swing;  // rad, as commanded last
  };
  static double calc_feedback(const Gains& gains, double angle, double rate);
  void swing(const Vehicle& vehicle, std::size_t chamber, double angle, Commands& commands);

  bool closed_ = false;
  std::array<Chamber, 4> chambers_{};
  std::array<int, 4> attitude_{};  // sensors: w, x, y, z
  std::array<int, 3> rate_{};
  Gains roll_, lateral_;
};

}  // namespace unlatch::fsw
