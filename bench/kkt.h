// The KKT system [M −Gᵀ; −G 0] (a; λ) = (F; −c) of bodies and joints in blocks, and solvers that use only these blocks.
//
// They are built for the present machine with all of Eigen's vectorisation, which the rest of the project must not use;
// so they are in a separate library, whose interface passes only plain numbers.
#pragma once

#include <memory>
#include <vector>

namespace unlatch::bench {

inline constexpr int kMostRows = 6;

struct KktBody {
  double mass;
  double inertia[9];  // world axes, symmetric
  double force[6];    // force and torque at the centre of mass, gyroscopic torque included
};

// Rows of G for a joint, row by row: coefficients of the two bodies' linear and angular accelerations.
struct KktJoint {
  int base, follower;  // base < follower; base −1 for the ground
  int count;           // rows, 1 … 6
  double base_rows[6 * kMostRows], follower_rows[6 * kMostRows];
  double bias[kMostRows];  // c
};

struct KktSystem {
  std::vector<KktBody> bodies;
  std::vector<KktJoint> joints;
};

#define UNLATCH_EXPORT [[gnu::visibility("default")]]

class UNLATCH_EXPORT KktSolver {
 public:
  virtual ~KktSolver() = default;
  virtual void solve() = 0;
  virtual const double* get_acceleration(int body) const = 0;  // 6 numbers
  virtual const double* get_multipliers(int joint) const = 0;  // one number for each row
};

// Throws unless joint k has body k + 1 as its follower and a body as its base: a tree whose root is free.
UNLATCH_EXPORT std::unique_ptr<KktSolver> build_textbook_solver(const KktSystem& system);
UNLATCH_EXPORT std::unique_ptr<KktSolver> build_dense_solver(const KktSystem& system);
UNLATCH_EXPORT std::unique_ptr<KktSolver> build_sparse_solver(const KktSystem& system);

}  // namespace unlatch::bench
