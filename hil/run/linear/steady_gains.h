// Steady-state gains of a linear model: what a constant input changes each output by in the end.
//
// G(s) = C (s − A)⁻¹ B + D at s → 0. With poles at 0 (a body that floats freely, a hinge without a spring) A has no
// inverse, but an output that the motions of those poles do not reach, or that the input does not excite them for,
// still has its gain: the angle by which an appendage bends while a torque accelerates the satellite. So the motions of
// the poles at 0 are split off: the Schur form with these poles first (Golub & Van Loan, Matrix Computations, 4th ed.,
// 7.6.2), and the Sylvester equation that decouples them from the others (7.6.3):
//
//   A = (V₁ V₂) diag(N, T) (W₁ W₂)ᵀ,   N nilpotent,   G(s) = Σ C V₁ Nᵏ W₁ᵀ B / sᵏ⁺¹ + C V₂ (s − T)⁻¹ W₂ᵀ B + D
//
// An entry has a gain where all its C V₁ Nᵏ W₁ᵀ B vanish within their estimated errors: D − C V₂ T⁻¹ W₂ᵀ B.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "unlatch/linear_model.h"

namespace unlatch::hil {

// Outputs × inputs, unit of the output per unit of the input.
struct SteadyGains {
  Eigen::MatrixXd values;  // infinite where a constant input moves the output without end
  Eigen::MatrixXd errors;  // estimated: those of the matrices carried over to the first order; infinite likewise
};

// `at_zero`: the poles of the model that count as 0; `slowest`: size of the smallest one that does not, 1/s (not read
// if all count as 0). If the other motions decay, the gains are what the outputs come to.
SteadyGains calc_steady_gains(const LinearModel& model, const std::vector<std::complex<double>>& at_zero,
                              double slowest);

}  // namespace unlatch::hil
