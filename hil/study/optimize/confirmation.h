// What follows from the fresh samples that judge a search's result: the demand of the next search, if there is one.
#pragma once

#include <optional>
#include <span>

#include "hil/study/optimize/evaluations.h"

namespace unlatch::hil {

// Returns true if one of the constraints that limit the nearest point, `against`, is a probability that it misses by
// the samples of the search, and fresh ones do not show that it misses it: the search had too few to say that nothing
// meets the constraints.
bool misses_unconfirmed(const OptimizeProblem& problem, const OptimizeSample& sample,
                        std::span<const std::size_t> against, const std::optional<DispersedCheck>& check);

// Returns true if the samples of the search alone deny the design, which fresh ones confirm: it meets the other
// constraints and has objectives.
bool is_denied_by_search_alone(const OptimizeProblem& problem, const OptimizeSample& sample,
                               const DispersedCheck& check);

// The margin that fresh samples leave to a constraint with a probability which they confirm, as far as other fresh ones
// would confirm a design without it, with so many deviations of their count (calc_confirmable); 0: none.
double calc_room(const OptimizeProblem& problem, std::size_t constraint, const DispersedCheck& check,
                 double deviations);

// Demand after a result, `sample`, that fresh samples have judged; `against`: constraints that it misses and that limit
// it, none if it is feasible; `deviations`: those with which a confirmed result has room (calc_room) at a limit that
// ends the search, nothing: it has none.
// Refuted: more samples, and that part of them that leads fresh ones to confirm the result; open: that part. Confirmed,
// with room, or although the samples of the search deny it: likewise a smaller part. No point found, and the nearest
// one not refuted: more samples. Nothing: the verdict of the fresh samples is that of the search, or it can ask for no
// more.
std::optional<OptimizeDemand> choose_demand(const OptimizeProblem& problem, const OptimizeEvaluations& evaluations,
                                            const OptimizeSample& sample, std::span<const std::size_t> against,
                                            std::optional<double> deviations, const DispersedCheck& check);

}  // namespace unlatch::hil
