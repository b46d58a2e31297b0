// Bodies of a model: rigid ones, those whose mass changes, flexible ones, and the markers that these carry.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

namespace unlatch {

inline constexpr int kGround = -1;  // index of the inertial frame among bodies
inline constexpr int kNone = -1;    // index of nothing: no channel, no element, …

// Unaligned, so that the model has one layout whether or not the user's own Eigen vectorises.
using Attitude = Eigen::Quaternion<double, Eigen::DontAlign>;

// Law of a body's mass, centre of mass and inertia: linear between the knots, constant beyond them.
struct MassLaw {
  enum class Of { kTime, kBurnt };  // the knots' variable: t, s; or what the body has burnt, kg
  // Mass properties at one value of the variable.
  struct Knot {
    double at, mass;          // s or kg; kg
    Eigen::Vector3d centre;   // of mass, from the body's origin, which is fixed in the structure; body axes, m
    Eigen::Matrix3d inertia;  // about the centre of mass, body axes, kg m²
  };
  Of of = Of::kTime;                               // variable of the knots
  std::vector<Knot> knots;                         // in rising order
  bool jet_damping = false;                        // see kernel/dynamics/varying.h
  Eigen::Vector3d exit = Eigen::Vector3d::Zero();  // where the particles leave, from the body's origin, body axes, m
};

// Small elastic deformations as m modes over the body's frame, whose origin is the undeformed centre of mass. The sums
// are over the body's particles at r with the mode shapes Φ_k, scaled so that Σ m |Φ_k|² = 1.
struct FlexibleBody {
  Eigen::VectorXd frequencies;            // ω_k, rad/s, > 0
  Eigen::VectorXd damping;                // ζ_k, of critical
  Eigen::Matrix3Xd momentum;              // Σ m Φ_k; 0 for modes of a body that nothing holds
  std::vector<Eigen::Matrix3d> first;     // Σ m r Φ_kᵀ
  std::vector<Eigen::Matrix3d> second;    // Σ m Φ_k Φ_lᵀ, at k · m + l
  Eigen::VectorXd initial, initial_rate;  // modal coordinates at the start and their rates, 1/s; empty for 0
};

// A frame without mass that a flexible body carries: what joints, loads and sensors are fixed to.
struct Marker {
  int body = 0;                                        // index of the flexible body
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // undeformed, from the body's origin, body axes, m
  Eigen::Matrix3Xd shape;                              // Φ_k there
  Eigen::Matrix3Xd turn;                               // Ψ_k: small rotation there per unit of the coordinate, rad
};

// A body, rigid unless one of law, flexible and marker is given.
struct Body {
  std::string name;                                   // unique among bodies
  double mass = 0;                                    // kg, > 0
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the centre of mass, body axes, kg m²
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();     // initial position of the centre of mass, m
  Attitude q_WB = Attitude::Identity();               // initial attitude, body to inertial
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();     // initial velocity of the centre of mass, inertial axes, m/s
  Eigen::Vector3d w_WB_B = Eigen::Vector3d::Zero();   // initial angular velocity, body axes, rad/s
  // At most one of these.
  std::optional<MassLaw> law;  // mass and inertia are then those at the start, the origin that of its structure
  std::optional<FlexibleBody> flexible;  // mass and inertia are then the undeformed ones
  std::optional<Marker> marker;          // nothing above is then read: it moves with its flexible body
};

}  // namespace unlatch
