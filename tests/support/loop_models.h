// Systems with many closed loops of bars and hinges, at rest: what deployable structures are made of. For tests and
// benchmarks of loops; the scissor mast is in mast_model.h. The first body is held to the ground. Joints that are
// listed last close the loops of programs that cut where the list says so (tree_links.h).
#pragma once

#include "unlatch/model.h"

namespace unlatch::test {

// Two rails with a rung at every joint of theirs; three bars and one loop a bay, in a plane.
Model build_ladder(int bays);

// Four-bar linkages, each standing on the coupler of the one before; three bars and one loop each, in a plane.
Model build_four_bars(int linkages);

// A lattice of hinged squares in a plane, `width` by `length` nodes with two bars each: as many loops are open at once
// as it is wide.
Model build_lattice(int width, int length);

// The pantograph ring of hil/scenarios/antenna with `cells` scissor cells between posts, the first of which is fixed:
// four bodies a cell, 2 cells + 1 loops that a single freedom moves.
Model build_pantograph_ring(int cells);

}  // namespace unlatch::test
