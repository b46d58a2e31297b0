// Quantities of shapes: clearances and contacts.
#pragma once

#include "kernel/elements/kinds/contact/contact.h"
#include "kernel/quantities/quantity_calc.h"

namespace unlatch::quantities {

// Of a guard far from its threshold a lower bound serves: see calc_guarded_distance().
inline void calc_clearance(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = own.guarded ? calc_guarded_distance(now.plan, ev, own.subject, own.other, own.threshold)
                       : calc_shape_distance(now.plan, ev, own.subject, own.other);
}

inline void calc_contact_force(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_contact(now, ev, own.subject).normal;
}

inline void calc_contact_depth(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = calc_contact(now, ev, own.subject).depth;
}

// A number of ContactTotals.
template <int which>
void calc_contact_total(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) {
  out[0] = ev.auxiliary.now[at(now.plan.contacts[at(own.subject)].auxiliary + which)];
}

inline void calc_closed(const Instant& now, const Evaluation&, const PlanQuantity& own, double* out) {
  const PlanContact& contact = now.plan.contacts[at(own.subject)];
  out[0] = 0;
  for (std::int32_t i = 0; i < contact.pairs; ++i)
    if (now.state.contacts[at(contact.first_pair + i)].closed != 0) out[0] = 1;
}

}  // namespace unlatch::quantities
