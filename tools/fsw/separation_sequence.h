// The separation cyclogram of strap-on boosters: what is commanded when, and how the contacts are answered. It knows
// the vehicle by the names in the simulator's catalog (throttle1, kr1, …), and as many boosters as it finds there. Of
// the nozzles of fuel tanks, and of the core's attitude loop, it commands those that the vehicle has.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/fsw/attitude_loop.h"
#include "tools/fsw/control_law.h"

namespace unlatch::fsw {

class SeparationSequence final : public ControlLaw {
 public:
  [[nodiscard]] std::string attach(const Vehicle& vehicle) override;
  void update(std::int64_t time_ns, const Vehicle& vehicle, Commands& commands) override;

 private:
  struct Booster {
    int throttle, rudder, cut_ties, cutoff, nozzle;  // channels
    int fuel_nozzle;                                 // -1: it has none
    int contact;                                     // sensor: the nose has moved off its seat
    std::int64_t contact_ns = kNever;
    bool nozzles_open = false;
  };
  static constexpr std::int64_t kNever = -1;

  AttitudeLoop attitude_loop_;
  std::vector<Booster> boosters_;
  int verniers_ = 0;
  int next_step_ = 0;  // of the cyclogram
};

}  // namespace unlatch::fsw
