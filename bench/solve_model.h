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
  // Many loops, at rest, most of them with three redundant rows (tests/support/mast_model.h, loop_models.h):
  kMast,      // a scissor mast of n/2 units
  kLadder,    // of n/3 bays
  kFourBars,  // n/3 four-bar linkages, each on the coupler of the one before
  kRing,      // a pantograph ring of n/4 cells, as that of hil/scenarios/antenna
  kTruss,     // a square lattice of n/2 nodes with two bars each: the loops that are open at once grow as its width
};
inline constexpr Shape kShapes[] = {Shape::kStar, Shape::kChain,  Shape::kBintree,  Shape::kRandom, Shape::kWeldedChain,
                                    Shape::kMast, Shape::kLadder, Shape::kFourBars, Shape::kRing,   Shape::kTruss};
const char* get_name(Shape shape);
// Many loops; multipliers are not unique.
constexpr bool has_many_loops(Shape shape) { return shape >= Shape::kMast; }

// Builds a system; with many loops the largest of its kind that has at most n bodies. A joint's base comes before its
// follower. The frames of each joint coincide, so that all angles are zero, and all rows are satisfied in position and
// velocity.
Model build_solve_model(Shape shape, int n);

}  // namespace unlatch::bench
