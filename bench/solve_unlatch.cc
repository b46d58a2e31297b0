#include <stdexcept>

#include "bench/solve_solver.h"
#include "kernel/dispatch/kernels.h"
#include "kernel/integration/integrator.h"
#include "kernel/solver/loops/loop_rows.h"
#include "tests/support/solve_comparison.h"

namespace unlatch::bench {
namespace {

class Unlatch : public Solver {
 public:
  Unlatch(const Model& model, InstructionSet set) : model_(model), simulation_(model_, {.instruction_set = set}) {
    check(evaluate_state(simulation_));
  }

  // Evaluates from poses and velocities; the modes are those of the call before.
  void solve() override { check(evaluate_state(simulation_, Changed::kMotion)); }

  Solution build_solution() override {
    const test::KernelSolution kernel = test::read_solution(simulation_);
    test::BodyAccelerations bodies{kernel.linear, {}};
    Solution solution;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b)
      bodies.angular.push_back(test::get_placement(model_, static_cast<int>(b)).R * kernel.angular[b]);
    solution.accelerations = calc_joint_accelerations(model_, bodies);
    for (const auto& joint : kernel.multipliers)
      solution.multipliers.insert(solution.multipliers.end(), joint.begin(), joint.end());
    return solution;
  }

 protected:
  static void check(int node) {
    if (node != kNone) throw std::runtime_error("unlatch: the pivot of node " + std::to_string(node) + " vanished");
  }

  Model model_;
  test::Simulation simulation_;
};

class UnlatchFactorSolve final : public Unlatch {
 public:
  using Unlatch::Unlatch;

  void solve() override {
    const PlanData& plan = simulation_.data();
    check(get_kernels(plan).factor_and_solve(plan, simulation_.state, simulation_.evaluation(), {}, kAllRows));
  }
};

}  // namespace

std::unique_ptr<Solver> build_unlatch(const Model& model) {
  return std::make_unique<Unlatch>(model, InstructionSet::kAuto);
}
std::unique_ptr<Solver> build_unlatch_avx2(const Model& model) {
  return std::make_unique<Unlatch>(model, InstructionSet::k256);
}
std::unique_ptr<Solver> build_unlatch_factor_solve(const Model& model) {
  return std::make_unique<UnlatchFactorSolve>(model, InstructionSet::kAuto);
}
std::unique_ptr<Solver> build_unlatch_factor_solve_avx2(const Model& model) {
  return std::make_unique<UnlatchFactorSolve>(model, InstructionSet::k256);
}

}  // namespace unlatch::bench
