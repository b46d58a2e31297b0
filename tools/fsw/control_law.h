// The control side of flight software, without the protocol: sensors and states in, commands out.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

// A control law cannot be loaded, or fails at a tick; what() is a sentence with the place and the reason.
class ControlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ControlLaw {
 public:
  virtual ~ControlLaw() = default;

  // A new session: looks up every channel and sensor that it needs, and begins anew. Returns what is missing, in words;
  // empty if nothing is. Throws ControlError.
  [[nodiscard]] virtual std::string attach(const Vehicle& vehicle) = 0;

  // Called once for each tick: reads the sensors, commands the channels. Throws ControlError.
  virtual void update(std::int64_t time_ns, const Vehicle& vehicle, Commands& commands) = 0;
};

}  // namespace unlatch::fsw
