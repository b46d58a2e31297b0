// Options of a sweep of the solver through the tree.
#pragma once

#include <cstdint>

namespace unlatch {

// The right-hand side of M a = F + Gᵀ λ.
enum class Source : std::int32_t {
  kForces,      // SharedBlock::force, and forces on modal coordinates
  kNothing,     // of corrections and impulses
  kBodyForces,  // SharedBlock::force alone
};

struct Sweep {
  Source source = Source::kForces;
  bool biased = true;       // false: the rows' right-hand sides are taken as zero
  bool multipliers = true;  // the forward pass computes them too
  double gamma_h = 0;       // s; a stage of ROS2: springs and modes that are integrated implicitly add to their pivots
};

}  // namespace unlatch
