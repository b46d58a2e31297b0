// Springs that a step does not resolve, found from the model before it is compiled.
#pragma once

#include <vector>

#include "unlatch/model.h"

namespace unlatch {

// Joint springs to be integrated implicitly: as the user has said, else those for which h ω, or h times the rate of
// their decay, is more than kResolved (unlatch/frequencies.h) in some mode of their joint. ω is that of the joint's two
// bodies alone, held by its rows, at their initial poses: more than it is with other bodies on them. O(1) per spring.
// h: s.
std::vector<bool> find_stiff_springs(const Model& model, double h);

}  // namespace unlatch
