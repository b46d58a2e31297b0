// Timing of the cyclic executive: the section `timing` of a scenario.
#pragma once

#include <cstdint>

namespace unlatch::hil {

// Policy for a tick whose work ended after the next tick was due.
struct OverrunPolicy {
  enum class Kind {
    kFail,        // the run ends
    kCatchUp,     // delayed ticks follow at once; more than max_ticks behind, the run ends
    kSlip,        // the next tick is a period later: simulated time falls behind wall time by the delay
    kSkipOutput,  // as kCatchUp without a bound, and the States of late ticks are not sent
  };
  Kind kind = Kind::kCatchUp;
  std::int64_t max_ticks = 10'000;
};

struct TimingOptions {
  OverrunPolicy overruns;
  double spin = 0;               // s of busy waiting before a deadline, after a warm-up step
  double watchdog = 5;           // s without activity of the cyclic thread until the watchdog reports it; 0: none
  bool watchdog_aborts = false;  // the watchdog then ends the process
  bool per_tick = false;         // the recording contains the times of every tick
};

}  // namespace unlatch::hil
