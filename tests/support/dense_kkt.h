// DenseKkt: the oracle of the tree solver. It assembles the whole system
//
//   M a = F + Gᵀ λ,   G a = c        a = (v_dot in inertial axes, w_dot in body axes) per body, F holds −w × J w
//
// as dense matrices and solves it by a rank-revealing factorisation with refinement in long double. It shares nothing
// with the kernel but the Model: no elimination order, no joint frames, no helper. Loops and redundant rows are
// allowed; then a is still unique and λ is the solution of least (row-scaled) norm. Cost: cubic in the number of
// bodies.
//
// Rows, from (4.11) and (4.12), with i the base, j the follower, n fixed in the base:
//   point–plane  g = n·(r_j − r_i);  rotation  n·(w_j − w_i) = 0;  universal: n ∥ x_base × y_follower.
// λ is the force (torque) of the base on the follower along n.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::test {

using Real = long double;
using RealVector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using RealMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

struct DenseBodyState {
  Eigen::Vector3d p_WB, v_WB;  // m, m/s, inertial axes
  Eigen::Quaterniond q_WB;     // body to inertial
  Eigen::Vector3d w_WB_B;      // rad/s, body axes
};

struct Wrench {  // at the centre of mass, inertial axes, N and N m
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
};

struct SystemState {
  std::vector<DenseBodyState> bodies;
  std::vector<int> modes;  // per joint, index into Joint::modes
};
SystemState build_initial_state(const Model& model);

struct DenseKkt {
  struct RowName {
    int joint, row;  // row: Row
  };
  RealMatrix mass;             // M, 6 n × 6 n
  RealMatrix rows;             // G, m × 6 n
  RealVector bias;             // c, m
  RealVector gyroscopic;       // −w × J w in the entries of w_dot, else 0
  RealVector speed;            // (v_WB, w_WB_B) per body
  std::vector<RowName> names;  // names of the m rows: joints in order, Row order within
};
DenseKkt build_dense_kkt(const Model& model, const SystemState& state);

struct DenseSolution {
  std::vector<Eigen::Vector3d> linear;                   // v_dot, inertial axes; for an impulse: change of v_WB
  std::vector<Eigen::Vector3d> angular;                  // w_dot, body axes; for an impulse: change of w_WB_B
  std::vector<Eigen::Matrix<double, 6, 1>> multipliers;  // per joint, by Row; 0 for inactive rows; N, N m (s)
  double condition = 0;  // estimated condition of the row-scaled G M^-1/2 without its null space
  int redundant = 0;     // number of rows that follow from the others
  double residual = 0;   // largest remaining entry of G a − c
};
DenseSolution solve_accelerations(const Model& model, const SystemState& state, const std::vector<Wrench>& wrenches);

// Solves a perfectly plastic impulse: M dv = Gᵀ Λ, G (v + dv) = 0.
DenseSolution solve_plastic_impulse(const Model& model, const SystemState& state);

}  // namespace unlatch::test
