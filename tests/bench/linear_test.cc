// The cost of a solve grows linearly with the number of bodies: by the count of its work, and by ratios of times within
// one process.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <memory>
#include <string>

#include "bench/solve_solver.h"
#include "tests/support/simulation.h"
#include "unlatch/cost/step_cost.h"

namespace unlatch::bench {
namespace {

constexpr int kSmall = 64, kLarge = 1024;
// Growth of the time per body over a sixteenfold n. Caches cost some: the small system lies in L2, the large one does
// not, and on a shared machine less of L3 is left for it (1.2 to 1.7 were seen). A term in n² would cost 16, one in
// n^1.5 4. One in n log n would cost 1.7 and is excluded, for trees, by the count of work below.
constexpr double kGrowth = 2.0;
// Growth with joints of all kinds: in a small system the branch predictor learns the order of the kinds.
constexpr double kGrowthOfMixture = 2.4;
constexpr int kPairs = 25;
// Growth of the counted work per body from n = 256 to 1024, where n log n would grow by 1.25. Blocks of eight bodies
// are fuller in large systems.
constexpr double kGrowthOfWork = 1.02;

// Processor time of this thread: other work of the machine does not count.
double get_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double measure_per_body(Solver& solver, int n) {
  const int calls = 8 * kLarge / n;  // equal number of bodies in both sizes
  const double start = get_cpu_seconds();
  for (int i = 0; i < calls; ++i) solver.solve();
  return (get_cpu_seconds() - start) / (calls * n);
}

// Growth from small to large systems, in turn, so that disturbances by the machine affect both; the least of each,
// which they affect least.
double calc_growth(Shape shape) {
  const std::unique_ptr<Solver> small = build_unlatch(build_solve_model(shape, kSmall));
  const std::unique_ptr<Solver> large = build_unlatch(build_solve_model(shape, kLarge));
  double least_small = std::numeric_limits<double>::infinity(), least_large = least_small;
  for (int i = 0; i < kPairs; ++i) {
    least_small = std::min(least_small, measure_per_body(*small, kSmall));
    least_large = std::min(least_large, measure_per_body(*large, kLarge));
  }
  return least_large / least_small;
}

// Instructions for a body of one integration, as counted from the plan.
double calc_work_per_body(Shape shape, int n) {
  const Model model = build_solve_model(shape, n);
  const Plan plan = test::compile_or_throw(model, {});
  const StepCost cost = calc_step_cost(plan, *find_cost_target("x86-64"), StepLimits{.follows = true});
  EXPECT_TRUE(cost.unmeasured.empty()) << get_name(shape);
  return cost.instructions / static_cast<double>(model.bodies.size());
}

TEST(Bench, CountedWorkIsLinearInTheNumberOfBodies) {
  for (const Shape shape : kShapes) {
    // Of many loops a bound counts the dense matrix, too, which a step falls back to where pivots of all loops vanish.
    if (has_many_loops(shape)) continue;
    const double growth = calc_work_per_body(shape, 1024) / calc_work_per_body(shape, 256);
    RecordProperty(get_name(shape), std::to_string(growth));
    EXPECT_LT(growth, kGrowthOfWork) << get_name(shape);
    EXPECT_GT(growth, 0.5) << get_name(shape);
  }
}

TEST(Bench, CostIsLinearInTheNumberOfBodies) {
  for (const Shape shape : kShapes) {
    if (shape == Shape::kTruss) continue;  // its frontier grows: LoopGraphs.ALatticeHasAFrontierAsWideAsItIs
    const double growth = calc_growth(shape);
    RecordProperty(get_name(shape), std::to_string(growth));
    EXPECT_LT(growth, shape == Shape::kRandom ? kGrowthOfMixture : kGrowth)
        << get_name(shape) << ": time per body at n = " << kLarge << " over n = " << kSmall;
  }
}

}  // namespace
}  // namespace unlatch::bench
