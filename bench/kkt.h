// The KKT system [M −Gᵀ; −G 0] (a; λ) = (F; −c) of a tree of hinges in blocks, and solvers that only take it as such.
//
// They are built for the machine at hand with all of Eigen's vectorisation, which the rest of the project must not use;
// so they live in a library of their own, whose border only plain numbers cross.
#pragma once

#include <memory>
#include <vector>

namespace unlatch::bench {

inline constexpr int kKktRows = 5;

struct KktBody {
  double mass;
  double inertia[9];  // world axes, symmetric
  double force[6];    // force and torque at the centre of mass, gyroscopic torque included
};

// Rows of G for a hinge, row by row: 5 × 6 coefficients of the two bodies' linear and angular accelerations.
struct KktHinge {
  int base, follower;  // base < follower
  double base_rows[6 * kKktRows], follower_rows[6 * kKktRows];
  double bias[kKktRows];  // c
};

struct KktSystem {
  std::vector<KktBody> bodies;
  std::vector<KktHinge> hinges;  // hinge k has body k + 1 as its follower
};

#define UNLATCH_EXPORT [[gnu::visibility("default")]]

class UNLATCH_EXPORT KktSolver {
 public:
  virtual ~KktSolver() = default;
  virtual void solve() = 0;
  virtual const double* get_acceleration(int body) const = 0;  // 6
  virtual const double* get_multipliers(int hinge) const = 0;  // kKktRows
};

UNLATCH_EXPORT std::unique_ptr<KktSolver> build_textbook_solver(const KktSystem& system);
UNLATCH_EXPORT std::unique_ptr<KktSolver> build_dense_solver(const KktSystem& system);
UNLATCH_EXPORT std::unique_ptr<KktSolver> build_sparse_solver(const KktSystem& system);

}  // namespace unlatch::bench
