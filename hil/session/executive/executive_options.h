// Options of a run in the loop.
#pragma once

#include <cstdint>

#include "hil/scenario/timing_options.h"
#include "hil/session/faults/fault_injector.h"
#include "hil/session/participants/session_options.h"
#include "hil/session/realtime/clock.h"
#include "hil/session/realtime/tick_source.h"

namespace unlatch::hil {

struct ExecutiveOptions : SessionOptions {
  TimingOptions timing;
  FaultInjector* faults = nullptr;                 // deliberate faults; null for none
  TickSource* ticks = nullptr;                     // real time: the source of ticks; null for the clock
  const Clock* clock = &kMonotonicClock;           // clock of all times of the session
  std::int64_t start_timeout_ns = 20'000'000'000;  // limit for the introductions of all required participants
  std::int64_t resend_ns = 20'000'000;             // lockstep: interval of States without an answer
  std::int64_t announce_ns = 10'000'000;           // Announcer: one message of Hello and the catalog, one of the source
};

}  // namespace unlatch::hil
