// Distances of a fixed list of random pairs of shapes, with the same bits in every build.
#pragma once

namespace unlatch::test {

// Prints one line for each two kinds, `distance/cone-box COUNT HASH`: a hash of all numbers of COUNT pairs' results.
void print_distance_hashes();

}  // namespace unlatch::test
