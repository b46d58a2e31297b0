// The structure for a page: bodies with their shapes, joints, loads, springs, and the position of each in a frame.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/report/frames.h"

namespace unlatch::tools {

// Lengths in m, axes as columns, bodies and joints by index, the ground as -1; `column`: the item's first in a frame.
nlohmann::ordered_json build_structure(const hil::Scenario& scenario, const hil::RunAnalysis& analysis,
                                       const FrameLayout& layout);

}  // namespace unlatch::tools
