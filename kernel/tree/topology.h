// Parents of the bodies: the elimination order of the joint graph.
#pragma once

#include <vector>

#include "kernel/plan/plan_data.h"

namespace unlatch {

struct Topology {
  std::vector<TreeNode> nodes;      // parents before children, level by level, siblings together
  std::vector<std::int32_t> loops;  // joints that are no edges: each closes a loop
};

// Edges are the joints that may hold rows or have implicit springs along the axes in `compliant`, and the pairs of a
// flexible body and its marker. Of the joints of a loop one is no edge: preferably one that may become free, then one
// with the fewest rows, then the one farthest from the ground. Each connected part is one tree. Its root is the body
// that a joint holds to the ground, else `root` if it is given and in this part, else the middle, so that the tree is
// shallowest. O(n log n), for sorting.
Topology compile_topology(const Model& model, const std::vector<RowSet>& compliant, int root);

}  // namespace unlatch
