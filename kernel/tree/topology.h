// Parents of the bodies: the elimination order of the joint graph.
#pragma once

#include <vector>

#include "kernel/plan/plan_data.h"

namespace unlatch {

struct Topology {
  std::vector<TreeNode> nodes;      // parents before children, level by level, siblings together
  std::vector<std::int32_t> loops;  // joints left over: each closes a loop
};

// The joints that may hold rows, or have implicit springs along the axes in `compliant`, make the edges, and flexible
// bodies with their markers. Where joints close a loop, one is left over: one that may let go before one that holds
// for ever, then one with the fewest rows, then the one farthest from the ground. Each connected part becomes one tree:
// rooted at the body that a joint holds to the ground, else at `root` if it is given and there, else in the middle,
// where the tree is shallowest. O(n log n), for sorting.
Topology compile_topology(const Model& model, const std::vector<RowSet>& compliant, int root);

}  // namespace unlatch
