// Run: one step while it is computed, with all that its parts share.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/motion.h"
#include "unlatch/step_data.h"

namespace unlatch {

// Status of an evaluation that stopped at a node, or with kRigidFailure: the motion has blown up, its geometry is
// singular, or a rigid contact failed.
StepStatus get_pivot_status(const PlanData& plan, const Evaluation& ev, int node) noexcept;

struct Run {
  const PlanData& plan;
  const Inputs& inputs;
  WorkspaceData& data;
  MotionLog* log;  // null if none was given
  StepReport report{};
  int node = kNone;  // the node whose pivot vanished

  State& state() const { return data.kept.state; }         // how far the step has got
  Evaluation& ev() const { return data.kept.evaluation; }  // of the latest try from there
  EventSearch& search() const { return data.search; }
  EventRecord& events() const { return data.events; }

  bool fail(StepStatus status) {
    report.status = status;
    return false;
  }
  // False, with the report's status, if a factorisation stopped at `failed_node`.
  bool check(int failed_node) {
    node = failed_node;
    return failed_node == kNone || fail(get_pivot_status(plan, ev(), failed_node));
  }
  Instant get_instant(double t) const { return {plan, inputs, state(), t}; }
};

// Copies the state and the evaluation of this instant, with its sensors and quantities.
void fill_knot(const Run& run, double now, MotionKnot& knot) noexcept;

}  // namespace unlatch
