// Laws of the instant: expressions over quantities, channels and tables. Those that forces read are computed before the
// forces, with the motion of the stage; all others after the solve, for guards and readings. Each is computed once.
//
// Cost: 2 to 5 ns a step of an expression, a table as in tables.h. No allocation, no loop that a model does not bound.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

enum class LawSet {
  kDriving,  // that forces read; needs kinematics, frames and coordinates of this stage
  kOthers,   // needs the whole evaluation of this instant
};

// ev.laws of a set, with the operands that it reads. kDriving: clears ev.table_exits first.
void update_laws(const Instant& now, LawSet set, Evaluation& ev) noexcept;

// Value of one law. The operands and laws that it reads must be there: update_laws().
double calc_law(const Instant& now, const Evaluation& ev, int law) noexcept;

}  // namespace unlatch
