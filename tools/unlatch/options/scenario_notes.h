// Remarks on a valid scenario before it runs.
#pragma once

#include <string>
#include <vector>

#include "hil/run/notices/resolution.h"
#include "hil/scenario/scenario.h"

namespace unlatch::tools {

// Parts of a valid scenario that cannot come true: an event whose time is after the end.
std::vector<std::string> list_notes(const hil::Scenario& scenario);

// Says on standard error which springs the step cannot integrate stably; `check` shows all of them.
void warn_of_unstable_elements(const hil::Scenario& scenario);

// Says on standard error that the flight software that the scenario requires takes no part in a run at full speed.
void warn_of_absent_flight_software(const hil::Scenario& scenario);

using hil::kAccurate, hil::kStable;

}  // namespace unlatch::tools
