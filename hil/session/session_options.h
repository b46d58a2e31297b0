// The session as the participants see it.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/messages/messages.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct SessionOptions {
  Pace pace = Pace::kLockstep;
  std::int64_t session = 0;    // number of this run
  std::int64_t last_tick = 0;  // the run ends there
  FlightSoftware flight_software;
  std::vector<SourceMessage> source = {};  // the scenario, for observers; empty: not published
};

}  // namespace unlatch::hil
