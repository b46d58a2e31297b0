// The cost of a solve grows linearly with the number of bodies; a ratio within one process.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <memory>
#include <vector>

#include "bench/solve_solver.h"

namespace unlatch::bench {
namespace {

constexpr int kSmall = 64, kLarge = 1024;
// Growth of the time per body over a sixteenfold n: caches cost some (the small system lies in L2, the large one does
// not), a term in n log n would cost 1.7 and one in n² 16.
constexpr double kGrowth = 1.6;
// Growth with joints of all kinds: in a small system the branch predictor learns the order of the kinds.
constexpr double kGrowthOfMixture = 2.4;
constexpr int kPairs = 25;

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

// Growth from small to large systems, in turn, so that disturbances by the machine affect both.
double calc_growth(Shape shape) {
  const std::unique_ptr<Solver> small = build_unlatch(build_solve_model(shape, kSmall));
  const std::unique_ptr<Solver> large = build_unlatch(build_solve_model(shape, kLarge));
  std::vector<double> ratios;
  for (int i = 0; i < kPairs; ++i) {
    const double before = measure_per_body(*small, kSmall);
    ratios.push_back(measure_per_body(*large, kLarge) / before);
  }
  std::nth_element(ratios.begin(), ratios.begin() + kPairs / 2, ratios.end());
  return ratios[kPairs / 2];
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
