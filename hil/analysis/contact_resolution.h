// How fast a contact swings and settles, for judging the step: as if no joint held its two bodies, which have then
// their greatest mobility.
#pragma once

#include "hil/analysis/resolution.h"
#include "unlatch/contacts.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct ContactRates {
  double omega = 0;  // rad/s: √(dF_n/dδ · mobility along the normal)
  double decay = 0;  // 1/s: of the slip by friction, or of the depth by damping, whichever is faster
  [[nodiscard]] double get_worst() const { return omega > decay ? omega : decay; }
};

// Of a contact as it is.
ContactRates calc_rates(const Model& model, const State& state, const Contact& contact, const ContactReading& reading);

// Of a blow in the middle of both bodies: n = 1, or n = 1.5 with the speed of its restitution; otherwise 0.
ContactRates estimate_rates(const Model& model, const Contact& contact);

// Why a step of h = dt / contact_substeps does not resolve it; empty: it does.
std::string describe_unresolved(const ContactRates& rates, double h);

}  // namespace unlatch::hil
