// A sub-step with closed contacts that is linearly implicit in their forces: ROS34PW2, a Rosenbrock–W method of order
// three with four stages (J. Rang, L. Angermann, "New Rosenbrock W-methods of order 3 for partial differential
// algebraic equations of index 1", BIT 45, 2005). For y' = f(y),
//
//   (I − γ h A) k_i = f(y + h Σ α_ij k_j) + h A Σ γ_ij k_j,   j < i,   y⁺ = y + h Σ b_i k_i ,
//
// is of order three for any A, L-stable and stiffly accurate for the forces that A holds. A holds the kinematics x' = v
// and, for each closed pair, one row along its normal and two across it, with the slopes of its force there; what
// couples friction to the depth is left to f. With the rows J (relative velocity of the materials), their slopes K and
// D (diagonal), and the responses Y of all bodies to a unit force along each row, all as they are at the beginning, Λ =
// J Y, a stage's rates are those of the step's own explicit evaluation and the response to z,
//
//   v' = f_v + Y z,   (Λ + (γ h D + γ² h² K)⁻¹) z = −J f_v − (γ h D + γ² h² K)⁻¹ (D g_v + K (γ h (J f_x + g_v) + g_x)),
//
// g = h Σ γ_ij of the rows' rates J k_j: Woodbury's formula for the matrix M − γ h D − γ² h² K. The matrix on the left
// is symmetric and positive definite. Joints, loads and all else stay in f, and rows of joints hold in each stage.
//
// Cost beside the explicit method's, which has as many evaluations: a solve by the present factor for each row, once
// for all tries of a sub-step; a factorisation of as many rows for each try.
//
// Stack: 26 kB for the rows, 16 kB for the stages.
#pragma once

#include <array>

#include "kernel/elements/kinds/contact/contact_parts.h"

namespace unlatch {

inline constexpr std::size_t kRowsPerPair = 3, kMostContactRows = kRowsPerPair * kMostImplicitPairs;

// A direction of a closed pair in which its force is integrated implicitly.
struct ContactRow {
  std::int32_t base, follower;      // bodies, or kGround
  std::int32_t impulse;             // into Auxiliary: impulse of the contact; kNone across the normal
  Vec3 u;                           // unit vector, W
  Vec3 lever_base, lever_follower;  // the body's rate of turn · lever: speed of its material along u; body axes, m
  double stiffness, damping;        // N/m, N s/m
};
// Those of a sub-step, from the evaluation of its beginning; the same for all tries.
struct ContactRows {
  std::size_t count = 0;  // 0: the sub-step is explicit
  std::array<ContactRow, kMostContactRows> rows;
  // per row and body: acceleration of the body by a unit force along the row, linear in W axes, of the turn in its own
  std::array<std::array<Spatial, kMostImplicitBodies>, kMostContactRows> responses;
  std::array<std::array<double, kMostContactRows>, kMostContactRows> mobility;  // Λ
};

// Rows of the pairs that are closed and on. Overwrites accelerations and forces of the evaluation.
void begin_contact_rows(const Instant& now, Evaluation& ev, ContactRows& rows) noexcept;

// The stages of one try of h seconds; start and first rates are in the evaluation's blocks (begin_substep()).
class ContactStages {
 public:
  static constexpr int kCount = 4;
  // Time of a stage after the beginning, in h.
  static double get_time(int stage) noexcept;

  ContactStages(const PlanData& plan, const ContactRows& rows, double h, Evaluation& ev) noexcept;
  // The first stage, which needs no evaluation: leaves the motion of the second.
  void begin() noexcept;
  // Another stage, of which `ev` is the evaluation: leaves the motion of the next, or of the end.
  void finish(int stage) noexcept;

 private:
  using PerRow = std::array<double, kMostContactRows>;

  [[nodiscard]] double calc_weighted(const std::array<PerRow, 4>& of, std::size_t stage, std::size_t row) const;
  void factor();
  void solve_rows(std::size_t stage);
  void add_responses(std::size_t stage);
  void move(std::size_t stage);

  const PlanData& plan_;
  const ContactRows& own_;
  const double h_;
  Evaluation& ev_;
  std::array<PerRow, kMostContactRows> factor_;  // LDLᵀ of the lower triangle, D in the diagonal
  PerRow inverse_slopes_, forces_;               // 1/(γ h d + γ² h² k); z
  std::array<PerRow, kCount> speeds_, places_;   // per stage: J k of velocities and of places
  std::array<std::array<MotionT<double>, kMostImplicitBodies>, kCount> rates_;  // per stage: k
  std::array<std::array<double, kMostImplicitAuxiliary>, kCount> auxiliary_;    // the same of auxiliary states
};

}  // namespace unlatch
