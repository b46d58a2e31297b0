// One step: t = tick · dt → (tick + 1) · dt. Read kernel/step/step.cc top to bottom.
#pragma once

#include "unlatch/motion.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/step_data.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Advances `state` by one tick. Quicker by a tenth where the latest call with this workspace left its outputs of this
// very state: the bits are the same. On any status but kOk the state is unchanged. Allocates nothing, takes no lock,
// makes no system call. `log`, if given, gets the knots of the motion inside the step; the bits are the same without.
[[nodiscard]] StepReport step(const Plan& plan, const Inputs& inputs, State& state, Workspace& workspace,
                              MotionLog* log = nullptr) noexcept;

// The accelerations, reactions and sensor values of a state: what step() leaves in the workspace for its new state,
// here for a state that no step produced, such as the initial one.
[[nodiscard]] StepStatus update_outputs(const Plan& plan, const Inputs& inputs, const State& state,
                                        Workspace& workspace) noexcept;

}  // namespace unlatch
