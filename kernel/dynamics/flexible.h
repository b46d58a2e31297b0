// Flexible bodies: a floating frame with modal coordinates, (3.5)–(3.8) of the paper. A particle at r from the frame's
// origin, the undeformed centre of mass, is at x = p + R u, u = r + Σ Φ_k η_k; its speed and the mass matrix of
// (v, w, dη/dt) need only the inertia invariants
//
//   S_k = Σ m Φ_k    G_k = Σ m r Φ_kᵀ    H_kl = Σ m Φ_k Φ_lᵀ    (sums over the particles; H_kk has trace 1)
//
// Joints, loads and sensors are at markers, frames without mass that the body carries: at r + Φ η, turned by the
// Rodrigues vector Ψ η / 2. The rest of the kernel treats a marker as a body.
//
// In the tree a flexible body is a node between its markers. The blocks of its outboard markers are added to its own,
// its modal coordinates are eliminated, and the block that is left, of 6 rows instead of 6 + m, is added to the marker
// that holds it, see flexible_solver.cc. Plain doubles, not lanes; models without flexible bodies do nothing here.
#pragma once

#include "kernel/elements/compliance.h"
#include "kernel/joints/joint_motion.h"
#include "kernel/math/matrix6.h"
#include "kernel/plan/evaluation.h"
#include "unlatch/plan.h"

namespace unlatch {

// A 3×3 matrix Σ m a bᵀ.
struct Moment {
  double xx, xy, xz, yx, yy, yz, zx, zy, zz;
};
UNLATCH_INLINE double trace(const Moment& a) { return (a.xx + a.yy) + a.zz; }
// Σ m a × b
UNLATCH_INLINE Vec3 cross_of(const Moment& a) { return {a.yz - a.zy, a.zx - a.xz, a.xy - a.yx}; }

// Numbers of a flexible body in PlanData::modal, per mode; `Access` makes them const where they are only read.
template <template <class> class Access>
struct ModalShapeOf {
  std::span<Access<Vec3>> momentum;     // S_k
  std::span<Access<Moment>> first;      // G_k
  std::span<Access<Moment>> second;     // H_kl; see get_second()
  std::span<Access<double>> stiffness;  // ω², 1/s²
  std::span<Access<double>> damping;    // 2 ζ ω, 1/s

  std::size_t count_modes() const { return momentum.size(); }
  const Moment& get_second(std::size_t k, std::size_t l) const { return second[k * count_modes() + l]; }
};
// Numbers of a marker there, per mode.
template <template <class> class Access>
struct MarkerShapeOf {
  std::span<Access<Vec3>> displacement, turn;  // Φ_k, Ψ_k
};
template <class T>
using Writable = T;
template <class T>
using ReadOnly = const T;
using ModalShape = ModalShapeOf<ReadOnly>;
using MarkerShape = MarkerShapeOf<ReadOnly>;
ModalShape get_shape(const PlanData& plan, const PlanFlexible& body) noexcept;

// Counts of these numbers, and their arrays from a first one on, for the compilation.
int get_shape_size(int modes) noexcept;
int get_marker_shape_size(int modes) noexcept;
ModalShapeOf<Writable> place_shape(int modes, double* numbers) noexcept;
MarkerShapeOf<Writable> place_marker_shape(int modes, double* numbers) noexcept;

// Memory for the evaluation of one flexible body at one stage. Arrays are per mode; spatial vectors in world axes.
struct ModalWork {
  // computed by add_flexible_forces()
  std::span<double> force;  // on the modal coordinates
  // computed by the solver's backward pass (flexible_solver.cc)
  Matrix6* A;              // block of the body and all outboard of it
  std::span<Spatial> B;    // its coupling with the modal coordinates
  LowerTriangle E;         // block of the modal coordinates, then its factor
  std::span<Spatial> C;    // B at the marker that holds the body
  std::span<Spatial> W;    // E⁻¹ Cᵀ
  std::span<Spatial> D;    // motion of the frame per modal coordinate while that marker stays
  std::span<double> free;  // E⁻¹ times the load of the modal coordinates
  // likewise, where nothing holds the body
  Matrix6* root;       // lower triangle: factor of the block that is left
  Spatial* root_load;  // the load that is left
  // computed by its forward pass
  std::span<double> acceleration;  // second derivatives of the modal coordinates, or their corrections
};
ModalWork get_work(const PlanFlexible& body, Evaluation& ev) noexcept;
int get_work_size(int modes) noexcept;

// A marker's turn in its body as a Rodrigues vector g, and how it changes.
struct MarkerTurn {
  Vec3 g, g_rate, w;  // w: of the marker relative to the body, body axes
  double scale;       // 1 / (1 + g²)
};

// Motion of one marker relative to its body at one stage, world axes but for the turn.
struct MarkerWork {
  // computed by update_markers()
  std::span<Spatial> columns;  // its velocity and angular velocity per modal rate
  Vec3* arm;                   // from the body's origin
  MarkerTurn* turn;            //
  // computed by update_marker_biases()
  Spatial* bias;  // its acceleration beyond those of the body and the modal coordinates
};
// The markers of one body, by their numbers in the plan.
class MarkerArray {
 public:
  MarkerArray(const PlanFlexible& body, Evaluation& ev) noexcept;
  MarkerWork operator[](int marker) const noexcept;

 private:
  double* numbers_;
  int size_, modes_, first_;
};
MarkerWork get_marker(const PlanFlexible& body, int marker, Evaluation& ev) noexcept;
int get_marker_size(int modes) noexcept;

// Poses and velocities of all markers, from their bodies and the modal coordinates.
void update_markers(const PlanData& plan, Evaluation& ev) noexcept;
// One marker's, given its body's and the modal coordinates with their rates.
BodyState calc_marker_state(const PlanData& plan, const PlanMarker& marker, const BodyState& body,
                            const double* coordinates, const double* rates) noexcept;

// Inertias in world axes, from the bodies' rotations and the modal coordinates.
void update_flexible_kinematics(const PlanData& plan, Evaluation& ev) noexcept;
// Biases of the markers for accelerations; zero for corrections.
void update_marker_biases(const PlanData& plan, RowTarget kind, Evaluation& ev) noexcept;
// Adds weight, centrifugal and Coriolis forces, stiffness and damping. The gyroscopic torque of the frame is among the
// forces with which init_forces() begins.
void add_flexible_forces(const PlanData& plan, const Vec3& origin, const Implicit& implicit, Evaluation& ev) noexcept;
// Rates of the modal coordinates in ev.auxiliary, with the accelerations of the latest solution.
void update_modal_rates(const PlanData& plan, Evaluation& ev) noexcept;
// At the end of a stage of ROS2, see compliance.h: x' = v + γh a1 of the first, x' = v + γh (a2 − 2 a1) of the second.
void lead_modal_rates(const PlanData& plan, const Implicit& implicit, Evaluation& ev) noexcept;
// No force on the modal coordinates.
void clear_modal_forces(const PlanData& plan, Evaluation& ev) noexcept;
// Adds the latest solution to the modal coordinates, as a displacement; to their rates, as a change of velocity.
void add_modal_displacements(const PlanData& plan, Evaluation& ev) noexcept;
void add_modal_velocities(const PlanData& plan, Evaluation& ev) noexcept;

// Momenta and kinetic energy of one flexible body; `coordinates`: its modal coordinates, then their rates.
Balance calc_flexible_balance(const PlanData& plan, const PlanFlexible& body, const BodyState& state,
                              const double* coordinates) noexcept;

}  // namespace unlatch
