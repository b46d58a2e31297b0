// Assemblies: bodies that joints hold together. The ground is one of the bodies.
#pragma once

#include <vector>

#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch::hil {

// Joints that hold an assembly together: those with any row; or those with all six, whose bodies cannot move relative
// to one another.
enum class Holding { kAny, kRigid };

// Assemblies of a state: bodies connected by joints with active rows, or a flexible body and its markers, are in one.
class Assemblies {
 public:
  Assemblies(const Model& model, const State& state, Holding holding = Holding::kAny);

  [[nodiscard]] bool are_joined(int a, int b) const { return get(a) == get(b); }
  // Bodies of the assembly that contains `body`, kGround included, in ascending order.
  [[nodiscard]] std::vector<int> list(int body) const;

 private:
  [[nodiscard]] int get(int body) const { return roots_[static_cast<std::size_t>(body + 1)]; }
  std::vector<int> roots_;  // by body + 1; the ground is 0
};

// Mass, centre of mass, motion and inertia of an assembly; the ground, markers and deformations of flexible bodies are
// left out.
struct AssemblyMotion {
  double mass = 0;                                     // kg; 0: the assembly contains the ground
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = p;  // centre of mass, W, m, m/s
  Eigen::Vector3d angular_momentum = p;                // about the centre of mass, W, kg m²/s
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();   // about the centre of mass, W, kg m²
};
// `bodies`: states of all bodies at `time`; `burnt`: kg, for the bodies with a mass law, in their order.
AssemblyMotion calc_motion(const Model& model, const std::vector<int>& list, const std::vector<BodyState>& bodies,
                           double time, std::span<const double> burnt);

// Free motion of a body about its axis of symmetry: the principal axis whose moment of inertia differs most from the
// other two, whose mean is I_t. Exact for a symmetrical body. L is the angular momentum about the centre of mass: the
// axis moves around L at the coning half-angle, once in a nutation period 2π I_t / |L|.
struct Coning {
  double half_angle = 0;  // rad, 0 to π/2
  double period = 0;      // s; infinite without angular momentum (slower than 1e-9 rad/s)
};
Coning calc_coning(const AssemblyMotion& motion);

}  // namespace unlatch::hil
