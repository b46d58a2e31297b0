// Instant: the conditions of one evaluation. The motion of the bodies is in the evaluation: read it from there
// (get_body_frame(ev, …), ev.auxiliary.now). In stages and tries `state.bodies` and `state.auxiliary` are still those
// of the beginning of the sub-step.
#pragma once

#include "kernel/elements/compliance.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/state.h"
#include "unlatch/step_data.h"

namespace unlatch {

// The branches of laws that jump (`if_less`). A stage takes those of the beginning of its sub-step, so that no stage
// sees the other side of a jump before the sub-step ends there (events/event_search.cc).
enum class Branches { kDecide, kHold };

struct Instant {
  const PlanData& plan;
  const Inputs& inputs;
  const State& state;   // modes and memory of joints, elements, events, signals; no motion, see above
  double t;             // s
  Implicit implicit{};  // stage of ROS2, if it is one
  Branches branches = Branches::kDecide;
};

}  // namespace unlatch
