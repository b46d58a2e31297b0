// Readings of elements at any instant of a step, from the evaluation: for quantities (kernel/quantities).
#pragma once

#include "kernel/elements/instant.h"
#include "unlatch/readings.h"

namespace unlatch {

// `element`: as in State::elements. `ev`: the evaluation of this instant.
ElementReading calc_element(const Instant& now, const Evaluation& ev, int element) noexcept;

}  // namespace unlatch
