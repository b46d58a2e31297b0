// How far a requirement's value may be wrong by the errors of the steps themselves, as those steps show that were taken
// again as two halves (hil/run/audit/step_audit.h). What lies between the steps is the matter of extreme_bounds.h.
//
// Of a place, a speed, an angle or a rate it is the error of that part of the bodies' motion: the largest relative
// error of its place and its velocity, times what it has changed. Of anything else, as a force, it is the largest
// relative error of any part of their motion, times the value. Both five times, since of an oscillation the audit sees
// a fifth to a third of the error.
#pragma once

#include "hil/run/analysis/requirements.h"
#include "hil/run/audit/step_audit.h"

namespace unlatch::hil {

// `until`: the end of the time that decides the value, s. In the requirement's unit.
double calc_step_uncertainty(const Model& model, const Requirement& requirement, double value, double until,
                             const StepAudit& audit);

}  // namespace unlatch::hil
