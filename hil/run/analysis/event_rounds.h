// The rounds in which events act at one instant, one after the other, and the states between them (kernel/THEORY.md,
// section 6).
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "unlatch/motion.h"
#include "unlatch/step_data.h"

namespace unlatch::hil {

struct EventRound {
  std::span<const FiredEvent> events{};
  const MotionKnot *before = nullptr, *after = nullptr;  // the states just before its actions and just after them
  bool is_lost = false;  // these states are not kept: it is one of several behind MotionLog::kMostRounds
};

// Rounds of an instant between two knots, in their order; at least one if there are events. `events`: those of the
// instant, `done` of the step being before them; `rounds`: of the step.
inline std::vector<EventRound> list_rounds(std::span<const FiredEvent> events, std::size_t done,
                                           const MotionKnot& before, const MotionKnot& after,
                                           std::span<const RoundKnot> rounds) {
  std::vector<EventRound> list;
  const MotionKnot* latest = &before;
  std::size_t used = 0;
  for (const RoundKnot& round : rounds) {
    if (round.knot.time != after.time || round.fired < done) continue;
    const std::size_t until = std::min(std::max(round.fired - done, used), events.size());
    list.push_back({events.subspan(used, until - used), latest, &round.knot});
    latest = &round.knot;
    used = until;
  }
  if (used < events.size()) list.push_back({events.subspan(used), latest, &after, true});
  return list;
}

}  // namespace unlatch::hil
