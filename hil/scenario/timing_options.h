// Timing of the cyclic executive: the section `timing` of a scenario.
#pragma once

#include <cstdint>

namespace unlatch::hil {

// Policy for a tick whose work ended after the next was due.
struct OverrunPolicy {
  enum class Kind {
    kFail,        // the run ends
    kCatchUp,     // ticks follow at once until none is due; more than max_ticks behind, the run ends
    kSlip,        // the next tick is a period later: simulated time falls behind wall time by what was lost
    kSkipOutput,  // as kCatchUp without a bound, and the States of ticks that end late are not sent
  };
  Kind kind = Kind::kCatchUp;
  std::int64_t max_ticks = 10'000;
};

struct TimingOptions {
  OverrunPolicy overruns;
  double spin = 0;               // s before a deadline that are waited through awake, after a warm-up step
  double watchdog = 5;           // s without a sign of life of the cyclic thread until the watchdog reports it; 0: none
  bool watchdog_aborts = false;  // and then ends the process
  bool per_tick = false;         // every tick's account goes into the recording
};

}  // namespace unlatch::hil
