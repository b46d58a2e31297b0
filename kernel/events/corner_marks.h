// Corners at the ends of a sub-step, for the log of the motion (unlatch/motion.h): two pieces of motion that meet at
// one are not one smooth curve, and no polynomial goes through knots on both sides.
//
// Cost: a look at each place of the laws, each table over time and each switch a sub-step, only where motion is logged.
#pragma once

#include <cstdint>
#include <span>

#include "kernel/events/corners.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/state.h"

namespace unlatch {

// What has corners, at both ends of a sub-step.
struct CornerCourse {
  CornerPlaces at_begin, at_end;
  std::span<const std::int32_t> from_begin, decided;  // branches of its stages; those at its end
};

// Both for a corner inside: the sub-step was not split there.
struct CornerEnds {
  bool at_begin = false, at_end = false;
  [[nodiscard]] bool any() const { return at_begin || at_end; }
};

struct CornerMarks {
  CornerEnds motion;    // of what forces read
  CornerEnds readings;  // of laws that only conditions, sensors and outputs read
  bool jumps = false;   // at the end a law decides otherwise than in the stages before it
  [[nodiscard]] bool any() const { return motion.any() || readings.any(); }
};

// Of a sub-step from `begin` to `end`. Steps are split at corners of laws that forces read, of travels, of the air and
// of tables over time, but for those that are finer than the step; not at those of laws that only outputs read.
// `state`: of its end, but before its events.
CornerMarks mark_corners(const PlanData& plan, const State& state, double begin, double end,
                         const CornerCourse& course) noexcept;
// Those of tables and masses over time and of switches alone.
CornerEnds mark_times(const PlanData& plan, const State& state, double begin, double end) noexcept;

// Gives the laws that jump at the end of the sub-step the branches of its stages. `branches`: Evaluation::branches, of
// its end.
void hold_branches(const PlanData& plan, double begin, double end, const CornerCourse& course,
                   std::span<std::int32_t> branches) noexcept;

}  // namespace unlatch
