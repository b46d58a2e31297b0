// Quantities of joints: coordinates, their rates, reactions, the mode.
#pragma once

#include "kernel/quantities/quantity_calc.h"

namespace unlatch::quantities {

inline void calc_coordinate(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = ev.coordinates[at(own.coordinate)];
}

inline void calc_speed(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = ev.speeds[at(own.coordinate)];
}

// Multipliers of a joint from row `first` on; those of rows that do not hold are 0.
template <int first, int count>
void calc_multipliers(const Instant&, const Evaluation& ev, const PlanQuantity& own, double* out) {
  for (int i = 0; i < count; ++i) out[i] = ev.multipliers.get(at(own.subject), at(first + i));
}

inline void calc_mode(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  out[0] = now.state.joints[at(own.subject)].mode == own.part ? 1 : 0;
}

}  // namespace unlatch::quantities
