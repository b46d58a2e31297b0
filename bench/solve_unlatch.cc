#include <stdexcept>

#include "bench/solve_solver.h"
#include "kernel/integrator.h"
#include "kernel/tree_solver.h"
#include "tests/support/simulation.h"

namespace unlatch::bench {
namespace {

class Unlatch : public Solver {
 public:
  explicit Unlatch(const Model& model) : model_(model), simulation_(model_) { evaluate_or_throw(); }

  void solve() override { evaluate_or_throw(); }

  Solution build_solution() const override {
    std::vector<double> bodies;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const Spatial a = simulation_.workspace.accelerations[b];
      bodies.insert(bodies.end(), {a.lin.x, a.lin.y, a.lin.z, a.ang.x, a.ang.y, a.ang.z});
    }
    Solution solution{calc_coordinates(model_, bodies), {}};
    for (std::size_t j = 0; j < model_.joints.size(); ++j)
      for (std::size_t r = 0; r < kHingeRows; ++r)
        solution.multipliers.push_back(simulation_.workspace.multipliers[j * kRows + r]);
    return solution;
  }

 protected:
  void evaluate_or_throw() {
    test::Simulation& s = simulation_;
    check(evaluate(s.plan, {s.commands}, s.state, s.get_time(), s.workspace));
  }

  static void check(int node) {
    if (node != kNone) throw std::runtime_error("unlatch: the pivot of node " + std::to_string(node) + " vanished");
  }

  Model model_;
  test::Simulation simulation_;
};

class UnlatchFactorSolve final : public Unlatch {
 public:
  using Unlatch::Unlatch;

  void solve() override { check(factor_and_solve(simulation_.plan, simulation_.state, simulation_.workspace, {})); }
};

}  // namespace

std::unique_ptr<Solver> build_unlatch(const Model& model) { return std::make_unique<Unlatch>(model); }
std::unique_ptr<Solver> build_unlatch_factor_solve(const Model& model) {
  return std::make_unique<UnlatchFactorSolve>(model);
}

}  // namespace unlatch::bench
