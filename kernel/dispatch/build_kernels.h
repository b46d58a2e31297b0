// The table of kernels for one width. Included by the file of each instruction set, with UNLATCH_ISA naming it.
#pragma once

#include "kernel/dispatch/kernels.h"
#include "kernel/dynamics/body_motion.h"
#include "kernel/dynamics/runge_kutta.h"
#include "kernel/joints/tree_joints.h"
#include "kernel/simd/arctangent_packs.h"
#include "kernel/solver/loops/split_clusters.h"
#include "kernel/solver/solve.h"

namespace unlatch::UNLATCH_ISA {

template <int kWidest>
constexpr Kernels build_kernels() {
  return {.update_kinematics = update_kinematics<kWidest>,
          .update_angular_velocities = update_angular_velocities<kWidest>,
          .init_forces = init_forces<kWidest>,
          .update_joints = update_joints<kWidest>,
          .update_joint_velocities = update_joint_velocities<kWidest>,
          .update_angles = update_angles<kWidest>,
          .factor_and_solve = factor_and_solve<kWidest>,
          .solve = solve<kWidest>,
          .split_cluster_rows = split_cluster_rows<kWidest>,
          .begin_substep = begin_substep<kWidest>,
          .begin_stages = begin_stages<kWidest>,
          .advance_stage = advance_stage<kWidest>,
          .finish_stages = finish_stages<kWidest>,
          .restart = restart<kWidest>,
          .finish_first_stage = finish_first_stage<kWidest>,
          .finish_second_stage = finish_second_stage<kWidest>,
          .add_displacements = add_displacements<kWidest>,
          .add_velocities = add_velocities<kWidest>};
}

}  // namespace unlatch::UNLATCH_ISA
