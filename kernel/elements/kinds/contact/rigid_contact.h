// Rigid contacts of a model: what they may be of, and how they begin.
#pragma once

#include "kernel/elements/kinds/contact/rigid_row.h"
#include "kernel/model/check.h"
#include "kernel/plan/plan_lists.h"

namespace unlatch {

// The mistakes of a rigid contact whose two surfaces are checked.
void validate_rigid_contact(const Contact& contact, const Check& check);

// Its numbers, and which of its pairs are closed at the start: those that touch within kRigidStart and neither approach
// nor part. `plan` has its pairs.
void compile_rigid_contact(const Contact& contact, PlanDraft& plan, PlanContact& own);

}  // namespace unlatch
