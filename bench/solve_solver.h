// Interface of the compared solvers: one acceleration solve from poses and velocities, repeatedly.
#pragma once

#include <memory>
#include <vector>

#include "bench/solve_model.h"
#include "tests/support/tree_links.h"

namespace unlatch::bench {

// Answer of one acceleration solve. Multipliers are not unique where rows are redundant or loops cut differently; the
// systems here have none such.
struct Solution {
  std::vector<double> accelerations;  // calc_joint_accelerations(); m/s², rad/s²
  std::vector<double> multipliers;    // 6 for each joint, 0 for inactive rows, N and N m; empty if there are none
};

class Solver {
 public:
  virtual ~Solver() = default;
  virtual void solve() = 0;  // the timed call
  virtual Solution build_solution() = 0;
};

using MakeSolver = std::unique_ptr<Solver> (*)(const Model& model);
using test::calc_joint_accelerations;

std::unique_ptr<Solver> build_unlatch(const Model& model);               // evaluate(): everything
std::unique_ptr<Solver> build_unlatch_factor_solve(const Model& model);  // factor() and solve() alone
std::unique_ptr<Solver> build_unlatch_avx2(const Model& model);          // with AVX2, even if the processor has AVX-512
std::unique_ptr<Solver> build_unlatch_factor_solve_avx2(const Model& model);
std::unique_ptr<Solver> build_textbook(const Model& model);
std::unique_ptr<Solver> build_eigen_dense(const Model& model);
std::unique_ptr<Solver> build_eigen_sparse(const Model& model);
std::unique_ptr<Solver> build_mujoco(const Model& model);         // if UNLATCH_BENCH_MUJOCO
std::unique_ptr<Solver> build_simbody(const Model& model);        // if UNLATCH_BENCH_SIMBODY
std::unique_ptr<Solver> build_simbody_solve(const Model& model);  // with the last factorisation

}  // namespace unlatch::bench
