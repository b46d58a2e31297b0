// Simbody's realize(Acceleration). Either positions and velocities are marked as changed before each call, so that
// everything is computed anew, or only the stages are invalidated: then Simbody keeps the results for the positions,
// its factorisation (articulated inertias) included, and merely solves.
#include "bench/solve_solver.h"
#include "tests/support/peers/simbody_system.h"

namespace unlatch::bench {
namespace {

class Simbody final : public Solver {
 public:
  enum class Keep { kNothing, kFactorisation };

  Simbody(const Model& model, Keep keep) : model_(model), keep_(keep), system_(model) { system_.solve(); }

  void solve() override {
    if (keep_ == Keep::kNothing)
      system_.solve();
    else
      system_.solve_factored();
  }
  Solution build_solution() override { return {calc_joint_accelerations(model_, system_.calc_accelerations()), {}}; }

 private:
  Model model_;
  Keep keep_;
  test::SimbodySystem system_;
};

}  // namespace

std::unique_ptr<Solver> build_simbody(const Model& model) {
  return std::make_unique<Simbody>(model, Simbody::Keep::kNothing);
}
std::unique_ptr<Solver> build_simbody_solve(const Model& model) {
  return std::make_unique<Simbody>(model, Simbody::Keep::kFactorisation);
}

}  // namespace unlatch::bench
