// Redundant rows of closed loops: rows that follow from the others, so that the reactions are not unique. They are
// split by the stiffnesses of the joints, Joint::share.
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

  bool operator==(const RedundantRows&) const = default;
};

// At the state that the workspace's outputs are of; empty if every reaction is unique. Allocates.
std::vector<RedundantRows> list_redundant_rows(const Plan& plan, const State& state, const Workspace& workspace);

}  // namespace unlatch
