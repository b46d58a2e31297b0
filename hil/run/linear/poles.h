// Poles of a linear model, each with a bound on its error, which distinguishes what is 0 from what is slow.
//
// To the first order an error E of A moves a simple pole by wᴴ E v / wᴴ v, with its right and left eigenvectors v and w
// (Golub & Van Loan, Matrix Computations, 4th ed., 7.2.2). m poles at 0 that belong to one chain of motions, as the
// position and the speed of a free body, are computed as a ring of the size ε^(1/m); wᴴ v is then so small that the
// bound is 1/m of the ring. Sixteen times the bound covers these too.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace unlatch::hil {

struct Pole {
  std::complex<double> value;  // 1/s
  double error;                // 1/s, estimated
  // Not distinct from 0: a free motion, or one that is slower than the model's errors let it distinguish.
  [[nodiscard]] bool is_at_zero() const { return std::abs(value) <= error; }
};

// Poles of A, 2f × 2f of f positions and their f speeds, in ascending order of their size. `A_error`: estimated errors
// of the entries, not below 0. O(f³).
std::vector<Pole> calc_poles(const Eigen::MatrixXd& A, const Eigen::MatrixXd& A_error);

// A of the same motion with time in units of 1/rate: entries of positions and of speeds are then of one size.
Eigen::MatrixXd scale_time(const Eigen::MatrixXd& A, double rate);

}  // namespace unlatch::hil
