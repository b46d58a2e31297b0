// What a step costs at most on a target, in instructions, from the plan alone. Work is counted in units (passes over
// blocks of bodies, joints, elements, pairs of shapes …), and each unit costs the most instructions that it was
// measured to take on that target; how often a step does what follows from the plan's limits: parts of a step while a
// contact is closed, splits, tries of searches, rounds of events. kernel/cost/README.md says how it is measured, and
// what it is not.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "unlatch/plan.h"

namespace unlatch {

// A target whose instructions have been measured.
struct CostTarget {
  const char* name;       // "cortex-m7"
  const char* processor;  // for readers: what was measured, and the compiler
  int lanes;              // numbers that the widest pack of its code holds
};
// All that are measured.
std::vector<const CostTarget*> list_cost_targets();
// The one of a name; null if there is none of this name.
const CostTarget* find_cost_target(const std::string& name);

// How often a step does what, at most.
struct StepLimits {
  bool follows = false;        // it begins with the very state that the last step ended with, only commands are new
  std::int64_t parts = 1;      // of the step, while a contact is closed
  std::int64_t splits = 0;     // at events
  std::int64_t sub_steps = 1;  // parts, and what splits, corners of laws and changes of features add
  std::int64_t searches = 0;   // integrations that locate events, touches and corners
  std::int64_t tries = 1;      // integrations: one for each sub-step, and those of searches
  std::int64_t rounds = 0;     // of events that act
  std::int64_t waits = 0;      // further rounds, in which an event only begins to wait for its delay
  std::int64_t jumps = 0;      // rounds in which velocities may jump: with impulses, or with rows that close
};
// Of any step of a plan.
StepLimits calc_step_limits(const Plan& plan) noexcept;

// Part of a step.
struct CostRow {
  const char* phase;  // for readers: "stages of an integration"
  double calls = 0;   // of it, at most
  double bodies = 0;  // instructions of all calls: kinematics, joint frames, motion
  double forces = 0;  // likewise: loads, elements, laws, coordinates
  double solver = 0;  // likewise: factorisations and solutions, loops included
  double rest = 0;    // likewise: everything else
  // All its instructions.
  double total() const { return bodies + forces + solver + rest; }
};

// What a step costs at most.
struct StepCost {
  std::vector<CostRow> rows;            // its parts, in order
  double instructions = 0;              // their sum
  std::vector<std::string> unmeasured;  // units of the plan that were not measured: then there is no bound
};
// Of a step that does as much as `limits` say: at most calc_step_limits(), or what a StepReport has counted.
StepCost calc_step_cost(const Plan& plan, const CostTarget& target, const StepLimits& limits);

// What a step has done, each at most.
struct StepCounts {
  std::int64_t integrations = 1;  // StepReport::substeps
  std::int64_t rounds = 0;        // StepReport::audits
  std::int64_t waits = 0;         // rounds in which some event began to wait for its delay
  std::int64_t jumps = 0;         // rounds in which velocities may have jumped
  std::int64_t timed = 0;         // splits at times that were known, which take no search
};
// Limits of a step that follows another one and has done so much.
StepLimits get_counted_limits(const Plan& plan, const StepCounts& counts) noexcept;

}  // namespace unlatch
