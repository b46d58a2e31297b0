// Values of the events' guards: ≥ 0 where a guard holds. Needs the lanes evaluated: ws.coordinates, ws.speeds and
// ws.multipliers.
#pragma once

#include <span>

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

struct Inputs;

// values[e] for every armed event at time t; negative for the others. Bodies and further coordinates are those in the
// lanes; `state` is for modes, events and signals.
void update_guards(const Plan& plan, const Inputs& inputs, const State& state, double t, Workspace& ws,
                   std::span<double> values) noexcept;

}  // namespace unlatch
