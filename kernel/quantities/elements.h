// Quantities of elements: forces, lengths, strokes; pushers, stops and cords by their number among one-sided forces.
#pragma once

#include "kernel/elements/element_reading.h"
#include "kernel/elements/kinds/one_sided/one_sided.h"
#include "kernel/quantities/quantity_calc.h"

namespace unlatch::quantities {

template <double ElementReading::*value>
void calc_reading(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_element(now, ev, own.subject).*value;
}

inline void calc_on_time(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  const ElementState& element = now.state.elements[at(own.subject)];
  out[0] = is_on(element, now.t) ? now.t - element.switched_on : 0;
}

inline OneSidedMotion calc_own_motion(const Instant& now, const Evaluation& ev, const PlanQuantity& own) {
  return calc_motion(now.plan, now.state, ev, now.plan.one_sided[at(own.subject)]);
}

inline void calc_one_sided_force(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_force(now.plan, now.state, now.t, now.plan.one_sided[at(own.subject)], calc_own_motion(now, ev, own));
}

inline void calc_engaged(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  out[0] = now.state.engaged[at(own.subject)] != 0 ? 1 : 0;
}

inline void calc_own_reach(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_reach(now.plan, now.plan.one_sided[at(own.subject)], calc_own_motion(now, ev, own));
}

inline void calc_wound(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_own_motion(now, ev, own).path.winding;
}

inline void calc_bearing(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_own_motion(now, ev, own).path.bearing;
}

}  // namespace unlatch::quantities
