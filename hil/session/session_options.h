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
  // Before the first Hello: listens for so long whether another simulator is there.
  std::int64_t listen_ns = 0;
  bool beside_others = false;              // starts although another simulator is heard; else it does not
  std::vector<SourceMessage> source = {};  // the scenario, for observers; empty: not published
};

}  // namespace unlatch::hil
