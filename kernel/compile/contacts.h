// Shapes and contacts of a plan: groups, pairs of shapes, damping from restitution, what is closed at the start.
#pragma once

#include "kernel/plan/plan_data.h"

namespace unlatch {

// Needs the initial motion of the bodies, and the scales of the elements before the contacts.
void compile_contacts(const Model& model, PlanData& plan);

// d, s/m, of a contact whose blow with `speed` (m/s) parts with `restitution` (0 < e ≤ 1) times that speed; the same
// for all masses, stiffnesses and exponents. From dE = F dδ: v dv/(1 + d v) has the same integral from v to 0 and from
// 0 to −e v, so that x = d v solves x (1 + e) = ln((1 + x)/(1 − e x)).
double calc_contact_damping(double restitution, double speed);

}  // namespace unlatch
