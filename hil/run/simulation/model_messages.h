// Messages about a model and its state: State in parts, the catalog, events. Publisher and recordings send and keep
// them.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "hil/session/messages/messages.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// State messages that one tick takes.
[[nodiscard]] std::int32_t count_state_parts(const Simulation& simulation) noexcept;
// Writes bodies, sensors (held ones as last sampled) and joint modes of one part, and its counts; session, sequence,
// status and hash are the caller's. `dt_ns`: the step.
void fill_state(const Simulation& simulation, std::int32_t part, std::int64_t dt_ns, StateMessage& message) noexcept;

// Messages, one per body, joint, channel, sensor value and signal; session is left 0.
std::vector<CatalogMessage> build_catalog(const Model& model);
// Messages of the model's events, with name and subject alone.
std::vector<EventMessage> build_event_messages(const Model& model);

}  // namespace unlatch::hil
