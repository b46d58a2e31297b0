// Natural frequency and decay rate of a contact, for judging the step. They are computed as if no joint held its two
// bodies, which gives their greatest mobility.
#pragma once

#include "hil/run/notices/resolution.h"
#include "unlatch/contacts.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct ContactRates {
  double omega = 0;  // rad/s: √(dF_n/dδ · mobility along the normal)
  double decay = 0;  // 1/s: of the slip by friction, or of the depth by damping, whichever is faster
  // Parts per second that the contact needs: blows accurately, h·ω ≤ kAccurate; a decaying slip stably, h·decay ≤
  // kStable. A body that sticks has ended its slip within a part or a few: how it did is lost, the motion after it is
  // not.
  [[nodiscard]] double calc_need() const {
    return omega / kAccurate > decay / kStable ? omega / kAccurate : decay / kStable;
  }
};

// Rates of a contact in its present state.
ContactRates calc_rates(const Model& model, const State& state, const Contact& contact, const ContactReading& reading);

// Rates of a blow in the middle of both bodies. For n = 1.5, and those of friction, they depend on its speed.
ContactRates estimate_rates(const Model& model, const Contact& contact, double speed);
// Sum of the inverse masses of a contact's two bodies, 1/kg: the mobility of a blow in the middle of both.
double calc_least_mobility(const Model& model, const Contact& contact);
// Greatest mobility of a slip, 1/kg: at the points of both surfaces that are the farthest from the centres of mass,
// about the axes of the least inertias. Allocates.
double calc_most_mobility(const Model& model, const Contact& contact);
// Speed of a blow that is still to come: that of its restitution; or that of the two bodies now, if they come nearer at
// more than 1 mm/s; else 1 m/s.
double estimate_speed(const Model& model, const State& state, const Contact& contact);

// Reason why a step of dt, cut into `parts` parts of h each, does not resolve the contact, and a step that does with as
// many parts; empty if it does.
std::string describe_unresolved(const ContactRates& rates, double dt, int parts);

}  // namespace unlatch::hil
