// What a simulator on a target announces (bridge/target): the frames of a Hello and of the catalog.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::bridge {

// Why a session of the scenario cannot be held on a target, with what mends it; empty: it can.
std::string find_target_obstacle(const hil::Scenario& scenario);
// A session in lockstep up to `last_tick`; its number and the sequence numbers are 0.
std::vector<std::uint8_t> build_session_image(const hil::Scenario& scenario, const hil::Simulation& simulation,
                                              std::int64_t last_tick);

}  // namespace unlatch::bridge
