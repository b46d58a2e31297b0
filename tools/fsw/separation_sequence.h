// The separation cyclogram of strap-on boosters: what is commanded when, and how the contacts are answered. It knows
// the vehicle by the names in the simulator's catalog (throttle1, kr1, …), and as many boosters as it finds there.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/fsw/vehicle.h"

namespace unlatch::fsw {

class SeparationSequence {
 public:
  // Looks up every channel and sensor that it needs. Returns what is missing, in words; empty if nothing is.
  [[nodiscard]] std::string attach(const Vehicle& vehicle);

  // Called once for each tick: reads the sensors, commands the channels. Never called twice for the same tick.
  void update(std::int64_t time_ns, const Vehicle& vehicle, Commands& commands);

 private:
  struct Booster {
    int throttle, rudder, cut_ties, cutoff, nozzle;  // channels
    int contact;                                     // sensor: the nose has moved off its seat
    std::int64_t contact_ns = kNever;
    bool nozzle_open = false;
  };
  static constexpr std::int64_t kNever = -1;

  std::vector<Booster> boosters_;
  int verniers_ = 0;
  int next_step_ = 0;  // of the cyclogram
};

}  // namespace unlatch::fsw
