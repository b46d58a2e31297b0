// How much a small change of the start grows: condition numbers of the places at the end with respect to the places and
// velocities at the start, and of the attitudes at the end with respect to the attitudes and rates at the start, by one
// more run per direction, without analyses. On rails that a
// body leaves late a metre of offset may become 200 m: then no step makes the result more certain than the start.
#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "hil/run/analysis/accuracy.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

inline constexpr double kNotableGrowth = 10;
inline constexpr std::size_t kMostGrowthBodies = 6;  // each costs twelve runs

// True if a run of `other`, which is the scenario at another step, ends at tick `last` where `simulation` has ended:
// places within 1e-4 of the largest way of a body, attitudes within 1e-4 rad. At such a step
// growth can be measured. False if that run fails.
bool ends_alike(const Scenario& other, std::int64_t last, const Simulation& simulation,
                const std::atomic<bool>& interrupted);

// Factors of at least kNotableGrowth, the largest first; nothing if it was interrupted, or the model has more than
// kMostGrowthBodies bodies that are no markers. Changes that joints do not allow do not count: what is left of one is
// seen after the first step of `scenario`. The runs are those of `flown`, the same scenario at the same or a longer
// step, to its tick `last`.
std::optional<std::vector<StartGrowth>> measure_growth(const Scenario& scenario, const Scenario& flown,
                                                       std::int64_t last, const std::atomic<bool>& interrupted);

}  // namespace unlatch::hil
