// Flexible bodies: a floating frame with modal coordinates, (3.5)–(3.8) of the paper. A particle at r from the frame's
// origin, the undeformed centre of mass, is at x = p + R u, u = r + Σ Φ_k η_k; its speed and the mass matrix of
// (v, w, dη/dt) need only the inertia invariants
//
//   S_k = Σ m Φ_k    G_k = Σ m r Φ_kᵀ    H_kl = Σ m Φ_k Φ_lᵀ    (sums over the particles; H_kk has trace 1)
//
// Joints, loads and sensors are at markers, frames without mass that the body carries: at r + Φ η, turned by the
// Rodrigues vector Ψ η / 2. To the rest of the kernel a marker is a body.
//
// In the tree a flexible body is a node between its markers. It takes in the blocks of the markers beyond it, and
// passes on, at the marker that it is held by, what is left when its modal coordinates are eliminated: a block of 6 + m
// becomes one of 6, see flexible_solver.cc. Plain doubles, not lanes; models without flexible bodies do nothing here.
#pragma once

#include "kernel/elements/compliance.h"
#include "kernel/joints/joint_motion.h"
#include "kernel/math/lower_triangle.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/plan.h"

namespace unlatch {

// Nine numbers of a 3×3 matrix Σ m a bᵀ, by rows.
struct Moment {
  const double* n;
};
UNLATCH_INLINE double trace(Moment a) { return (a.n[0] + a.n[4]) + a.n[8]; }
// Σ m a × b
UNLATCH_INLINE Vec3 cross_of(Moment a) { return {a.n[5] - a.n[7], a.n[6] - a.n[2], a.n[1] - a.n[3]}; }

// Numbers of a flexible body with m modes in PlanData::modal; Number is double where they are written, const double
// where they are read.
template <class Number>
struct ModalShapeOf {
  int modes;
  Number* momentum;   // 3 m: S
  Number* first;      // 9 m: G
  Number* second;     // 9 m²: H, kl
  Number* stiffness;  // m: ω², 1/s²
  Number* damping;    // m: 2 ζ ω, 1/s

  Vec3 get_momentum(int k) const { return {momentum[3 * k], momentum[3 * k + 1], momentum[3 * k + 2]}; }
  Moment get_first(int k) const { return {first + 9 * k}; }
  Moment get_second(int k, int l) const { return {second + 9 * (k * modes + l)}; }
};
using ModalShape = ModalShapeOf<const double>;
ModalShape get_shape(const PlanData& plan, const PlanFlexible& body) noexcept;

// Numbers of a marker in PlanData::modal: its displacement Φ and its turn Ψ, three per mode.
template <class Number>
struct MarkerShapeOf {
  Number *displacement, *turn;
};
using MarkerShape = MarkerShapeOf<const double>;

// How many these are, and their places from a first one on, for the compilation.
int get_shape_size(int modes) noexcept;
int get_marker_shape_size(int modes) noexcept;
ModalShapeOf<double> place_shape(int modes, double* numbers) noexcept;
MarkerShapeOf<double> place_marker_shape(int modes, double* numbers) noexcept;

// Six numbers per mode, one mode behind the other.
struct SixPerMode {
  double* numbers;

  UNLATCH_INLINE double* operator[](int mode) const { return numbers + 6 * mode; }
};

// Memory for the evaluation of one flexible body with m modes at one stage; six-vectors in world axes.
struct ModalWork {
  // computed by add_flexible_forces(), then by the solver
  double* force;         // m, on the modal coordinates
  double* acceleration;  // m: second derivatives of the modal coordinates, or their corrections
  double* A;             // 6 × 6 by rows: block of the body and all beyond it
  SixPerMode B;          // its coupling with the modal coordinates
  LowerTriangle E;       // m × m: block of the modal coordinates, then its factor
  SixPerMode C;          // B at the marker that holds the body
  SixPerMode W;          // E⁻¹ Cᵀ
  SixPerMode D;          // how the modal coordinates move the frame when the marker stays
  double* free;          // m: E⁻¹ times the load of the modal coordinates
  // where nothing holds the body:
  LowerTriangle root;  // 6 × 6: factor of the block that is left
  double* root_load;   // 6
};
ModalWork get_work(const PlanFlexible& body, Evaluation& ev) noexcept;
int get_work_size(int m) noexcept;

// Motion of one marker relative to its body at one stage, world axes. Computed by update_markers() and
// update_marker_biases().
struct MarkerWork {
  SixPerMode columns;  // velocity and angular velocity of the marker per modal rate
  double* arm;         // 3: from the body's origin
  double* bias;        // 6: what its acceleration is beyond that
};
MarkerWork get_marker(const PlanFlexible& body, int marker, Evaluation& ev) noexcept;
int get_marker_size(int m) noexcept;

// Poses and velocities of all markers, from their bodies and ev.auxiliary.
void update_markers(const PlanData& plan, Evaluation& ev) noexcept;
// One marker's, given its body's and the modal coordinates with their rates.
BodyState calc_marker_state(const PlanData& plan, const PlanMarker& marker, const BodyState& body,
                            const double* coordinates, const double* rates) noexcept;

// Inertias in world axes, after update_kinematics().
void update_flexible_kinematics(const PlanData& plan, Evaluation& ev) noexcept;
// For accelerations; zero for corrections.
void update_marker_biases(const PlanData& plan, RowTarget kind, Evaluation& ev) noexcept;
// Weight, centrifugal and Coriolis forces, stiffness and damping; the gyroscopic torque of the frame is there.
void add_flexible_forces(const PlanData& plan, double t, const Implicit& implicit, Evaluation& ev) noexcept;
// Takes the modal accelerations of the latest solution for rates of ev.auxiliary.
void update_modal_rates(const PlanData& plan, Evaluation& ev) noexcept;
// At the end of a stage of ROS2, see compliance.h: x' = v + γh a1 of the first, x' = v + γh (a2 − 2 a1) of the second.
void lead_modal_rates(const PlanData& plan, const Implicit& implicit, Evaluation& ev) noexcept;
// Nothing pushes the modal coordinates.
void clear_modal_forces(const PlanData& plan, Evaluation& ev) noexcept;
// Takes the latest solution as a displacement of the modal coordinates, or as a change of their rates.
void add_modal_displacements(const PlanData& plan, Evaluation& ev) noexcept;
void add_modal_velocities(const PlanData& plan, Evaluation& ev) noexcept;

// Momenta and kinetic energy of one flexible body; `coordinates`: its modal coordinates, then their rates.
Balance calc_flexible_balance(const PlanData& plan, const PlanFlexible& body, const BodyState& state,
                              const double* coordinates) noexcept;

}  // namespace unlatch
