// What every solver of the comparison does: one acceleration solve from poses and velocities, again and again.
#pragma once

#include <memory>

#include "bench/solve_model.h"

namespace unlatch::bench {

class Solver {
 public:
  virtual ~Solver() = default;
  virtual void solve() = 0;  // what is timed
  virtual Solution build_solution() const = 0;
};

using MakeSolver = std::unique_ptr<Solver> (*)(const Model& model);

std::unique_ptr<Solver> build_unlatch(const Model& model);               // evaluate(): everything
std::unique_ptr<Solver> build_unlatch_factor_solve(const Model& model);  // factor() and solve() alone
std::unique_ptr<Solver> build_textbook(const Model& model);
std::unique_ptr<Solver> build_eigen_dense(const Model& model);
std::unique_ptr<Solver> build_eigen_sparse(const Model& model);
std::unique_ptr<Solver> build_mujoco(const Model& model);         // if UNLATCH_BENCH_MUJOCO
std::unique_ptr<Solver> build_simbody(const Model& model);        // if UNLATCH_BENCH_SIMBODY
std::unique_ptr<Solver> build_simbody_solve(const Model& model);  // the same, with the last factorisation

}  // namespace unlatch::bench
