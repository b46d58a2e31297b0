// Quantities of the instant: time, signals, commands, laws.
#pragma once

#include "kernel/quantities/quantity_calc.h"

namespace unlatch::quantities {

inline void calc_time(const Instant& now, const Evaluation&, const PlanQuantity&, double* out) { out[0] = now.t; }

// An event from which time is measured keeps the time of its latest action in `due`, see PlanEvent::timed.
inline void calc_since(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  const EventState& event = now.state.events[at(own.subject)];
  out[0] = event.phase != EventPhase::kPending && event.due >= 0 ? now.t - event.due : 0;
}

inline void calc_signal(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  out[0] = now.state.signals[at(own.subject)] != 0 ? 1 : 0;
}

inline void calc_command(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  out[0] = now.inputs.commands[at(own.subject)];
}

// Computed with the evaluation, see kernel/laws.
inline void calc_law_value(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = ev.laws[at(own.subject)];
}

}  // namespace unlatch::quantities
