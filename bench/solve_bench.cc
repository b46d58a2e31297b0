// Acceleration solves. solve/<who>/<shape>/<n>: one solve of n bodies by unlatch and by other programs;
// step/<shape>/<n> and step_avx2/…: whole steps of structures with many loops; plan/<shape>/<n>: compiling the plan.
// bench/README.md lists the contents of each call. Before a solver is timed its answer is compared with unlatch's, and
// the program ends at once if they differ: a comparison of different physics is worthless.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "bench/least.h"
#include "bench/solve_solver.h"
#include "tests/support/simulation.h"
#include "unlatch/plan.h"

namespace unlatch::bench {
namespace {

// Largest differences, relative to the largest entry. Exact solvers differ by rounding, which a long chain amplifies.
constexpr double kAgreement = 1e-9;
// SimplicialLDLT solves a matrix with −1e-8 in its corner: rows yield by 1e-8 of their multipliers.
constexpr double kRegularisedAgreement = 1e-4;
// Simbody's rank-revealing decomposition of the loops' rows; and MuJoCo's soft rows, which yield by 1e-4 of what they
// bear.
constexpr double kDecomposedAgreement = 1e-7, kSoftAgreement = 0.05;

// Largest n; the solver fails or is too slow for larger ones; 0: no size.
struct Sizes {
  int trees, chains, welded_chain, loops;
};
struct Peer {
  const char* name;
  MakeSolver build;
  Sizes largest;
  bool linear;
  double agreement, loop_agreement = kAgreement;
  InstructionSet needs = InstructionSet::kAuto;
};

const Peer kPeers[] = {
    {"unlatch", build_unlatch, {100000, 100000, 16384, 4096}, true, kAgreement},
    {"unlatch_factor_solve", build_unlatch_factor_solve, {100000, 100000, 16384, 4096}, true, kAgreement},
    {"unlatch_avx2", build_unlatch_avx2, {2048, 2048, 2048, 2048}, true, kAgreement, kAgreement, InstructionSet::k256},
    {"unlatch_factor_solve_avx2",
     build_unlatch_factor_solve_avx2,
     {2048, 2048, 2048, 2048},
     true,
     kAgreement,
     kAgreement,
     InstructionSet::k256},
    {"textbook", build_textbook, {4096, 4096, 0, 0}, true, kAgreement},
    {"eigen_sparse", build_eigen_sparse, {1024, 1024, 1024, 0}, true, kRegularisedAgreement},
    {"eigen_dense", build_eigen_dense, {64, 64, 64, 0}, false, kAgreement},
#ifdef UNLATCH_BENCH_SIMBODY
    {"simbody", build_simbody, {4096, 4096, 0, 128}, true, kAgreement, kDecomposedAgreement},
    {"simbody_solve", build_simbody_solve, {4096, 4096, 0, 0}, true, kAgreement},
#endif
#ifdef UNLATCH_BENCH_MUJOCO
    // Its reader nests elements 100 deep at most.
    {"mujoco", build_mujoco, {1024, 64, 0, 128}, false, kAgreement, kSoftAgreement},
#endif
};

int get_largest(const Sizes& sizes, Shape shape) {
  if (has_many_loops(shape)) return sizes.loops;
  if (shape == Shape::kWeldedChain) return sizes.welded_chain;
  return shape == Shape::kChain ? sizes.chains : sizes.trees;
}

// Powers of two from 8 to 2048 are the sizes over which the order of the cost is fitted.
constexpr int kFitted[] = {8, 16, 32, 64, 128, 256, 512, 1024, 2048};
constexpr int kOthers[] = {5, 1000, 4096, 16384, 100000};
constexpr int kTrusses[] = {200, 800};  // 10 and 20 nodes wide
constexpr int kKept = 4096;             // bodies at most

// Five hinges between two welds leave some multipliers undetermined: every solver has another answer. A ring has three
// cells or more.
int get_smallest(Shape shape) {
  if (shape == Shape::kRing) return 16;
  return shape == Shape::kWeldedChain || has_many_loops(shape) ? 8 : 1;
}

double calc_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0, difference = a.size() == b.size() ? 0 : HUGE_VAL;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    largest = std::max(largest, std::abs(b[i]));
    const double d = std::abs(a[i] - b[i]);
    difference = d <= difference ? difference : d;  // NaN counts as a difference
  }
  return difference / largest;
}

// Where rows are soft, a long chain of loops yields too much: false, and there is no time to compare.
bool check_or_abort(const Peer& peer, Shape shape, const Model& model, const Solution& answer) {
  const std::unique_ptr<Solver> reference = build_unlatch(model);
  const Solution expected = reference->build_solution();  // answer at its construction
  const double accelerations = calc_difference(answer.accelerations, expected.accelerations);
  const bool unique = !answer.multipliers.empty() && !has_many_loops(shape);
  const double multipliers = unique ? calc_difference(answer.multipliers, expected.multipliers) : 0;
  const double agreement = has_many_loops(shape) ? peer.loop_agreement : peer.agreement;
  if (accelerations <= agreement && multipliers <= agreement) return true;
  if (agreement == kSoftAgreement) return false;
  std::fprintf(
      stderr,
      "solve_bench: %s and unlatch disagree on %s/%zu: accelerations by %.1e, multipliers by %.1e of the largest "
      "(allowed %.0e). They do not solve the same system; their times would say nothing.\n",
      peer.name, get_name(shape), model.bodies.size(), accelerations, multipliers, agreement);
  std::abort();
}

std::unique_ptr<Solver> build_checked(const Peer& peer, Shape shape, int n) {
  const Model model = build_solve_model(shape, n);
  std::unique_ptr<Solver> solver = peer.build(model);
  solver->solve();
  if (!check_or_abort(peer, shape, model, solver->build_solution())) return nullptr;
  return solver;
}

// Times a solver. Repetitions are many and short, so the solver is kept from one to the next, unless it is large.
void run_solve(benchmark::State& bench, const Peer& peer, Shape shape) {
  static std::map<std::tuple<const char*, Shape, int>, std::unique_ptr<Solver>> kept;
  const int n = static_cast<int>(bench.range(0));
  std::unique_ptr<Solver> own;
  std::unique_ptr<Solver>& solver = n <= kKept ? kept[{peer.name, shape, n}] : own;
  if (!solver) solver = build_checked(peer, shape, n);
  if (!solver) return bench.SkipWithError("its rows yield by more than 5 % of the largest acceleration");
  for (auto _ : bench) {
    solver->solve();
    benchmark::ClobberMemory();
  }
  bench.SetComplexityN(n);
}

// Whole steps, from the beginning again after each hundred, so that all are of one part of the motion.
void run_step(benchmark::State& bench, InstructionSet set, Shape shape) {
  constexpr int kSteps = 100;
  test::Simulation simulation(build_solve_model(shape, static_cast<int>(bench.range(0))), {.instruction_set = set});
  int steps = 0;
  for (auto _ : bench) {
    if (++steps % kSteps == 0) init_state(simulation.plan, simulation.state);
    const StepReport report = simulation.advance();
    if (report.status != StepStatus::kOk) return bench.SkipWithError("a step failed");
    benchmark::ClobberMemory();
  }
  bench.SetComplexityN(bench.range(0));
}

void run_plan(benchmark::State& bench, Shape shape) {
  const Model model = build_solve_model(shape, static_cast<int>(bench.range(0)));
  for (auto _ : bench) benchmark::DoNotOptimize(compile_plan(model, {}));
}

void register_solves() {
  for (const Peer& peer : kPeers)
    for (const Shape shape : kShapes) {
      const int largest = get_largest(peer.largest, shape);
      if (largest == 0 || !is_supported(peer.needs)) continue;
      const std::string name = std::string("solve/") + peer.name + "/" + get_name(shape);
      const auto run = [&peer, shape](benchmark::State& bench) { run_solve(bench, peer, shape); };
      auto* fitted = benchmark::RegisterBenchmark(name.c_str(), run);
      for (const int n : kFitted)
        if (n >= get_smallest(shape) && n <= largest) fitted->Arg(n);
      fitted->Apply(keep_least);
      if (peer.linear && shape != Shape::kTruss) fitted->Complexity(benchmark::oN);
      const auto add = [&](int n) {
        if (n >= get_smallest(shape) && n <= largest)
          benchmark::RegisterBenchmark(name.c_str(), run)->Arg(n)->Apply(keep_least);
      };
      for (const int n : kOthers) add(n);
      for (const int n : kTrusses)
        if (shape == Shape::kTruss) add(n);
    }
}

void register_steps() {
  for (const auto& [prefix, set] :
       {std::pair("step/", InstructionSet::kAuto), std::pair("step_avx2/", InstructionSet::k256)})
    for (const Shape shape : kShapes) {
      if (!has_many_loops(shape) || !is_supported(set)) continue;
      auto* steps =
          benchmark::RegisterBenchmark((prefix + std::string(get_name(shape))).c_str(),
                                       [set = set, shape](benchmark::State& bench) { run_step(bench, set, shape); });
      for (const int n : kFitted)
        if (n >= std::max(get_smallest(shape), 16)) steps->Arg(n);
      if (shape == Shape::kTruss)
        steps->Arg(kTrusses[0]);
      else
        steps->Complexity(benchmark::oN);
      steps->Apply(keep_least);
    }
}

void register_plans() {
  for (const Shape shape : kShapes) {
    const auto run = [shape](benchmark::State& bench) { run_plan(bench, shape); };
    auto* plan = benchmark::RegisterBenchmark((std::string("plan/") + get_name(shape)).c_str(), run)
                     ->Unit(benchmark::kMicrosecond);
    if (has_many_loops(shape))
      plan->Arg(16)->Arg(1024)->Arg(shape == Shape::kTruss ? 3200 : 20000);  // 20,000 bodies: a mast of 10,000 units
    else
      plan->Arg(5)->Arg(1024)->Arg(100000);
  }
}

}  // namespace
}  // namespace unlatch::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  unlatch::bench::register_solves();
  unlatch::bench::register_steps();
  unlatch::bench::register_plans();
  try {
    benchmark::RunSpecifiedBenchmarks();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "solve_bench: %s\n", error.what());
    return 1;
  }
  benchmark::Shutdown();
}
