// The oracle of bodies with modal coordinates: point masses tied to each other by springs in a lattice. Its modes come
// from a dense eigensolver; its motion from d'Alembert's principle mass by mass, in long double, without the inertia
// invariants that a kernel would precompute:
//   x_i = p + R (r_i + Φ_i η),   Σ m_i J_iᵀ x_i'' = Σ J_iᵀ f_i − stiffness and damping of the modes,   J_i = ∂x_i'/∂u,
// with the speeds u = (p' in inertial axes, angular velocity in the frame's axes, η').
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "tests/support/dense_kkt.h"

namespace unlatch::test {

// Input of a kernel for a flexible body: data of each point mass, in the axes of the body's frame.
struct ModalBody {
  std::vector<double> masses;  // m_i, kg
  std::vector<Eigen::Vector3d>
      positions;                         // r_i, undeformed, from the frame's origin (the undeformed centre of mass), m
  std::vector<Eigen::Matrix3Xd> shapes;  // Φ_i, 3 × modes, m per unit of modal coordinate
  Eigen::VectorXd frequencies;           // ω_k, rad/s; modal masses Σ m_i |Φ_ik|² are 1
  Eigen::VectorXd damping;               // 2 ζ_k ω_k, 1/s
  Eigen::Index get_modes() const { return frequencies.size(); }
};

enum class Support {
  kFree,     // modes of the free lattice: they carry neither momentum nor, at rest, angular momentum
  kClamped,  // its first four points stay in the frame: modes that carry both
};
// Builds a mast of a square cross-section: `bays` squares of four points along x, each tied to the next by bars and
// diagonals. It has the lowest modes; masses vary along it so that it has no symmetry. Throws if there are fewer modes.
ModalBody build_lattice_mast(int bays, int modes, Support support);

struct FlexibleState {
  Eigen::Vector3d p_WB, v_WB;     // frame's origin, m, m/s, inertial axes
  Eigen::Quaterniond q_WB;        // frame to inertial
  Eigen::Vector3d w_WB_B;         // rad/s, the frame's axes
  Eigen::VectorXd eta, eta_rate;  // modal coordinates, their rates
};

// Mass matrix of (6 + modes)² and right-hand side: M (v', w', η'') = F, without constraints. Constraints may be added
// with the points' Jacobians as in DenseKkt.
struct FlexibleSystem {
  RealMatrix mass;
  RealVector force;
};
// Assembles the system. `forces`: on every point mass, N, inertial axes; empty for none.
FlexibleSystem calc_flexible_system(const ModalBody& body, const FlexibleState& state,
                                    const std::vector<Eigen::Vector3d>& forces);
// Acceleration of a point: x_i'' = J a + bias.
struct PointJacobian {
  Eigen::Matrix<Real, 3, Eigen::Dynamic> J;
  Eigen::Matrix<Real, 3, 1> bias;
};
PointJacobian calc_point_jacobian(const ModalBody& body, const FlexibleState& state, std::size_t point);

struct FlexibleAcceleration {
  Eigen::Vector3d linear, angular;  // v', inertial axes, m/s²; w', the frame's axes, rad/s²
  Eigen::VectorXd modal;            // η''
};
FlexibleAcceleration calc_flexible_acceleration(const ModalBody& body, const FlexibleState& state,
                                                const std::vector<Eigen::Vector3d>& forces);

}  // namespace unlatch::test
