// When loads may be on, which exclude each other, and how many ramps may end in one step: from the plan's events alone.
#pragma once

#include <cstdint>
#include <vector>

#include "kernel/plan/plan_data.h"

namespace unlatch::cost {

// The earliest time at which each event may act, s; infinite if it never may. An event acts no earlier than its
// condition may hold, by the times of the plan, the signals that it reads, and the modes of the joints.
std::vector<double> calc_earliest_times(const PlanData& plan);

// A time span within which an element may be on, s.
struct OnSpan {
  double from = 0, to = 0;
};
// Of each element the spans of its flight; none if it is never on.
std::vector<std::vector<OnSpan>> list_on_spans(const PlanData& plan);

// Of each element one that it takes over from: it is switched on by one event alone, which switches that one off for
// good; they are never on together. No element has two successors. kNone if there is none.
std::vector<std::int32_t> list_predecessors(const PlanData& plan);

// Splits of one step at corners whose times are known (kernel/events/corners.h), at most: of ramps that begin once in a
// flight, those end in one step that may; with others and with tables over time as many as a step may have.
std::int64_t count_timed_corners(const PlanData& plan);

}  // namespace unlatch::cost
