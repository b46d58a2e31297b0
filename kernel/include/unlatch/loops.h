// What the closed loops of a plan cost, estimated before anything runs.
#pragma once

#include <cstdint>

#include "unlatch/plan.h"

namespace unlatch {

// Multiplications of one factorisation and solution; a sub-step has five and one more solution. Loops count with all rows
// that their joints can hold: where some are redundant, or kept only at the beginning of a sub-step, they take less.
struct LoopCost {
  std::int32_t clusters = 0;  // sets of loops that share bodies or meet others that do: each is eliminated by itself
  std::int64_t tree = 0;      // without its loops
  std::int64_t loops = 0;     // what these add; grows with the square of the loops that are open at one body
};

// Estimates it from the plan alone. Time and memory: linear in the size of the plan.
LoopCost calc_loop_cost(const Plan& plan);

}  // namespace unlatch
