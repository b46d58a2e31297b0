// What the instruments read: ws.sensors. Needs everything that one evaluation leaves in the workspace.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

void update_sensors(const Plan& plan, const State& state, Workspace& ws) noexcept;

}  // namespace unlatch
