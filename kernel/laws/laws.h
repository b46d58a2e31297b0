// Laws of the instant: expressions over quantities, channels and tables. Those that forces read are computed before the
// forces, with the motion of the stage; all others after the solve, for guards and readings. Each is computed once.
//
// Cost: 2 to 5 ns a step of an expression, a table as in tables.h. No allocation, no loop that a model does not bound.
#pragma once

#include <span>

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Laws that forces read, with the operands that they read: from the motion and the coordinates of the stage. Clears
// ev.table_exits. Returns ev.laws.
std::span<const double> update_driving_laws(const Instant& now, Evaluation& ev) noexcept;
// All other laws and operands: from the accelerations and forces of the instant as well.
void update_other_laws(const Instant& now, Evaluation& ev) noexcept;

// What a law leaves beside its value.
struct LawTraces {
  std::span<TableExit> exits;        // per table
  std::span<double> places;          // as PlanLawStep::place
  std::span<std::int32_t> branches;  // likewise; read instead of written where the instant holds its branches
};
// Value of one law. `operands`: as PlanLaws::operands; `laws`: those that it reads.
double calc_law(const Instant& now, std::span<const double> operands, std::span<const double> laws,
                const LawTraces& traces, int law) noexcept;

}  // namespace unlatch
