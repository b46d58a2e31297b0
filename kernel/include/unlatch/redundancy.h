// Closed loops. Their redundant rows: rows that follow from the others, so that the reactions are not unique; they are
// split by the stiffnesses of the joints, Joint::share. And what loops cost, estimated before anything runs.
#pragma once

#include <cstdint>
#include <vector>

#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Joints of loops that share joints, and how many of their rows are redundant.
struct RedundantRows {
  std::vector<std::int32_t> joints;  // of the model, in its order
  std::int32_t rows = 0;             // that hold in them
  std::int32_t redundant = 0;        // of these, > 0
  // Of these, rows that follow from the others only nearly: of axes that should be parallel and are some 3e-7 rad off,
  // or of loops that hold structures 3e11 times as heavy as their own bodies. The joints do not hold them.
  std::int32_t nearly = 0;

  bool operator==(const RedundantRows&) const = default;
};

// At the state that the workspace's outputs are of; empty if every reaction is unique. Allocates.
std::vector<RedundantRows> list_redundant_rows(const Plan& plan, const State& state, const Workspace& workspace);

// Multiplications of one factorisation and solution; a sub-step has five and one more solution. Loops count with all
// rows that their joints can hold: where some are redundant, or kept only at the beginning of a sub-step, they take
// less.
struct LoopCost {
  std::int32_t clusters = 0;  // sets of loops that share bodies or meet others that do: each is eliminated by itself
  std::int64_t tree = 0;      // without its loops
  std::int64_t loops = 0;     // what these add; grows with the square of the loops that are open at one body
};

// Estimates it from the plan alone. Time and memory: linear in the size of the plan.
LoopCost calc_loop_cost(const Plan& plan);

}  // namespace unlatch
