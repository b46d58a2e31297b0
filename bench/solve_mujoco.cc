#include "bench/solve_solver.h"
#include "tests/support/peers/mujoco_system.h"

namespace unlatch::bench {
namespace {

class MuJoCo final : public Solver {
 public:
  explicit MuJoCo(const Model& model) : model_(model), system_(model) {}

  void solve() override { system_.solve(); }
  Solution build_solution() override { return {calc_joint_accelerations(model_, system_.calc_accelerations()), {}}; }

 private:
  Model model_;
  test::MujocoSystem system_;
};

}  // namespace

std::unique_ptr<Solver> build_mujoco(const Model& model) { return std::make_unique<MuJoCo>(model); }

}  // namespace unlatch::bench
