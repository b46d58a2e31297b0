// Instant: the conditions of one evaluation, beside the motion of the bodies, which is in the blocks.
#pragma once

#include "kernel/dynamics/compliance.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/state.h"
#include "unlatch/step.h"

namespace unlatch {

struct Instant {
  const PlanData& plan;
  const Inputs& inputs;
  const State& state;   // modes and memory of joints, elements, events, signals
  double t;             // s
  Implicit implicit{};  // stage of ROS2, if it is one
};

}  // namespace unlatch
