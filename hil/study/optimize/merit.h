// Order of samples: the least violation of constraints first, then the objective (Deb 2000). Objectives are scaled by
// their size at the first sample, constraints by their limit, so that they are comparable.
#pragma once

#include <optional>
#include <vector>

#include "hil/study/optimize/evaluations.h"
#include "hil/study/optimize/optimizers.h"

namespace unlatch::hil {

// Largest violation of a sample's constraints, relative to its limit: 0 if all are met.
struct Violation {
  double size = 0;
  std::optional<std::size_t> constraint;  // the violated one; nothing: the constraints are met,
  std::optional<std::size_t> objective;   // and this objective has no value
};

class OptimizeMerit {
 public:
  static constexpr double kNoResult = 100;  // scaled violation of a run without a result
  static constexpr double kWithin = 1e-6;   // scaled margin in searches, so that an optimum meets the constraints

  // `start`: the first sample; null: unknown, scales are 1. Keeps a reference to the problem.
  OptimizeMerit(const OptimizeProblem& problem, const OptimizeSample* start);

  // Scales a sample. `shifts`: added to the constraints, relative to their limits.
  [[nodiscard]] ScaledSample scale(const OptimizeSample& sample, const std::vector<double>& shifts = {}) const;
  [[nodiscard]] Violation calc_violation(const OptimizeSample& sample) const;
  // Violation relative to the limit; kNoResult if the run gives no value.
  [[nodiscard]] double calc_violation(const OptimizeSample& sample, std::size_t constraint) const;
  [[nodiscard]] bool is_feasible(const OptimizeSample& sample) const { return calc_violation(sample).size == 0; }
  // Returns true for less violation, or none and a better first objective.
  [[nodiscard]] bool is_better(const OptimizeSample& sample, const OptimizeSample& other) const;
  // Feasible samples that no other dominates, ordered by the first objective.
  [[nodiscard]] std::vector<std::size_t> find_front(const std::vector<OptimizeSample>& samples) const;
  // Point of a front that is nearest to the best of each objective, ranges scaled to 1.
  [[nodiscard]] std::size_t find_middle(const std::vector<OptimizeSample>& samples,
                                        const std::vector<std::size_t>& front) const;

  [[nodiscard]] double objective_scale(std::size_t i) const { return objective_scales_[i]; }
  [[nodiscard]] double constraint_scale(std::size_t i) const { return constraint_scales_[i]; }

 private:
  const OptimizeProblem& problem_;
  std::vector<double> objective_scales_, constraint_scales_;
};

}  // namespace unlatch::hil
