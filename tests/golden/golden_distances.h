// Distances of a fixed list of random pairs of shapes, whose bits every build must give.
#pragma once

namespace unlatch::test {

// One line for each two kinds, `distance/cone-box COUNT HASH`: of all numbers of COUNT pairs' results.
void print_distance_hashes();

}  // namespace unlatch::test
