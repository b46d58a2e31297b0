#include "tools/fsw/attitude_loop.h"

#include <algorithm>

#include "tools/fsw/needs.h"

namespace unlatch::fsw {

std::string AttitudeLoop::attach(const Vehicle& vehicle) {
  *this = AttitudeLoop{};
  if (vehicle.find_channel("swing1") < 0) return "";
  Needs needs(vehicle);
  for (std::size_t k = 0; k < chambers_.size(); ++k)
    chambers_[k].channel = needs.channel("swing" + std::to_string(k + 1));
  for (std::size_t i = 0; i < attitude_.size(); ++i) attitude_[i] = needs.sensor(std::string("attitude.") + "wxyz"[i]);
  for (std::size_t i = 0; i < rate_.size(); ++i) rate_[i] = needs.sensor(std::string("gyro.") + "xyz"[i]);
  roll_ = {needs.initial_value("roll_attitude_gain"), needs.initial_value("roll_rate_gain")};
  lateral_ = {needs.initial_value("attitude_gain"), needs.initial_value("rate_gain")};
  closed_ = needs.get_missing().empty();
  if (closed_)
    for (Chamber& chamber : chambers_) chamber.swing = vehicle.get_limits(chamber.channel).initial;
  return needs.get_missing();
}

double AttitudeLoop::calc_feedback(const Gains& gains, double angle, double rate) {
  return -gains.attitude * angle - gains.rate * rate;
}

void AttitudeLoop::update(const Vehicle& vehicle, Commands& commands) {
  if (!closed_) return;
  const double half = vehicle.get_sensor(attitude_[0]) < 0 ? -2 : 2;  // of two quaternions the one of the shorter turn
  std::array<double, 3> u{};
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double angle = half * vehicle.get_sensor(attitude_[i + 1]);
    u[i] = calc_feedback(i == 0 ? roll_ : lateral_, angle, vehicle.get_sensor(rate_[i]));
  }
  swing(vehicle, 0, u[0] + u[1], commands);
  swing(vehicle, 1, u[0] + u[2], commands);
  swing(vehicle, 2, u[0] - u[1], commands);
  swing(vehicle, 3, u[0] - u[2], commands);
}

void AttitudeLoop::swing(const Vehicle& vehicle, std::size_t chamber, double angle, Commands& commands) {
  Chamber& one = chambers_[chamber];
  const Vehicle::Limits& limits = vehicle.get_limits(one.channel);
  const double limited = std::clamp(angle, limits.minimum, limits.maximum);
  if (limited == one.swing) return;
  one.swing = limited;
  commands.set(one.channel, limited);
}

}  // namespace unlatch::fsw
