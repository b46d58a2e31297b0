// Session as the participants see it.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/scenario/scenario.h"
#include "hil/session/messages/messages.h"

namespace unlatch::hil {

struct SessionOptions {
  Pace pace = Pace::kLockstep;
  std::int64_t session = 0;    // number of this run
  std::int64_t last_tick = 0;  // last tick of the run
  FlightSoftware flight_software;
  // Time of listening for another simulator before the first Hello.
  std::int64_t listen_ns = 0;
  bool beside_others = false;              // starts also if another simulator is heard
  std::vector<SourceMessage> source = {};  // the scenario, for observers; empty: not published
};

}  // namespace unlatch::hil
