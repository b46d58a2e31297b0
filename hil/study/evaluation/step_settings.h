// A scenario at another step, as settings: the step, and with it the refinement of parts that contacts choose.
//
// Such a part is as long at every step (kernel/elements/kinds/contact/contact_parts.h). So that runs at several steps
// differ by the error of that choice too, a step that is n times as short has parts that are n times as fine; longer
// ones leave the parts as they are.
#pragma once

#include <vector>

#include "hil/scenario/scenario.h"
#include "hil/scenario/yaml/setting.h"

namespace unlatch::hil {

// `step`: whole nanoseconds, s. The settings read as the same doubles.
std::vector<Setting> make_step_settings(const Scenario& scenario, double step);

}  // namespace unlatch::hil
