// Comparison of the kernel's answer to one solve with the dense one: the only part of the property tests that depends
// on the place of the kernel's results.
#pragma once

#include <vector>

#include "tests/support/dense_kkt.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"

namespace unlatch::test {

// Linear and angular (body axes) accelerations, or changes of velocity after an impulse, and the multipliers.
struct KernelSolution {
  std::vector<Eigen::Vector3d> linear, angular;
  std::vector<Eigen::Matrix<double, 6, 1>> multipliers;  // per joint, by Row
};
KernelSolution read_solution(const Simulation& simulation);

// Velocities and modes in the form of the oracle.
SystemState read_state(const Simulation& simulation);

// Adds random forces and torques on every body, N and N m, to the model as loads in world axes; returns them for the
// oracle.
std::vector<Wrench> add_random_loads(Model& model, Random& random);

// Largest difference of any acceleration and of any multiplier, each relative to the largest of its kind, or to one
// unit where all are smaller, such as in a system that is welded to the ground.
struct Disagreement {
  double accelerations = 0, multipliers = 0;
  double get_worst() const { return std::max(accelerations, multipliers); }
};
Disagreement compare(const KernelSolution& kernel, const DenseSolution& dense);
Disagreement compare(const DenseSolution& a, const DenseSolution& b);

// Compares the generalised forces Gᵀ λ, for redundant rows: there the multipliers are not unique.
Disagreement compare_row_forces(const KernelSolution& kernel, const DenseSolution& dense, const DenseKkt& kkt);

// Change of the dense solution for a relative change of all its inputs: masses, inertias, points, axes, velocities,
// loads. A backward stable solver's error is a small multiple of this times the unit roundoff.
double calc_condition(const Model& model, const SystemState& state, const std::vector<Wrench>& wrenches,
                      Random& random);

}  // namespace unlatch::test
