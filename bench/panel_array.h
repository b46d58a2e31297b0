// A solar array of many panels, folded like an accordion on a free bus.
#pragma once

#include "unlatch/model.h"

namespace unlatch::bench {

// Builds the array. Hinge k joins panel k to the one before it, the first to the bus; a spring drives it to angle zero,
// where an event closes an elastic latch.
Model build_panel_array(int panels);

}  // namespace unlatch::bench
