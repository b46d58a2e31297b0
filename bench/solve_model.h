// Systems for the comparison of solvers: n bodies with random masses, joints, attitudes and speeds, under gravity.
#pragma once

#include "unlatch/model.h"

namespace unlatch::bench {

enum class Shape {
  kStar,         // the root free, all joints revolute
  kChain,        // likewise
  kBintree,      // likewise
  kRandom,       // an irregular tree: every body hangs on any before it, on a joint of any kind; the root free
  kWeldedChain,  // a chain that hangs on a hinge to the ground and whose tip is welded to the ground: 6 rows of a loop
  kMast,  // a scissor mast of n/2 units (tests/support/mast_model.h): n/2 − 1 loops, each with three redundant rows
};
inline constexpr Shape kShapes[] = {Shape::kStar,   Shape::kChain,       Shape::kBintree,
                                    Shape::kRandom, Shape::kWeldedChain, Shape::kMast};
const char* get_name(Shape shape);

// Builds a system. A joint's base comes before its follower. The frames of each joint coincide, so that all angles are
// zero, and all rows are satisfied in position and velocity.
Model build_solve_model(Shape shape, int n);

}  // namespace unlatch::bench
