// Kernels: the stages of a step that work on packs, compiled once for each instruction set. The templates are in the
// folders of kernel/ that each comment below names; their files document them.
#pragma once

#include "kernel/joints/joint_motion.h"
#include "kernel/plan/evaluation.h"
#include "kernel/solver/sweep.h"

namespace unlatch {

struct Kernels {
  // dynamics/body_motion.h
  void (*update_kinematics)(const PlanData&, Evaluation&);
  void (*update_angular_velocities)(const PlanData&, Evaluation&);
  void (*init_forces)(const PlanData&, Evaluation&);
  // joints/tree_joints.h
  void (*update_joints)(const PlanData&, Evaluation&, RowTarget);
  void (*update_joint_velocities)(const PlanData&, Evaluation&);
  // simd/arctangent_packs.h
  void (*update_angles)(double* sines, const double* cosines, std::size_t count);
  // solver/solve.h
  int (*factor_and_solve)(const PlanData&, const State&, Evaluation&, const Sweep&, std::int32_t most_rows);
  void (*solve)(const PlanData&, Evaluation&, const Sweep&);
  // solver/loops/split_clusters.h
  void (*split_cluster_rows)(const PlanData&, const State&, Evaluation&);
  // dynamics/runge_kutta.h
  void (*begin_substep)(const PlanData&, Evaluation&);
  void (*begin_stages)(const PlanData&, Evaluation&, double weight, double h);
  void (*advance_stage)(const PlanData&, Evaluation&, double weight, double h);
  void (*finish_stages)(const PlanData&, Evaluation&, double weight, double h);
  void (*restart)(const PlanData&, Evaluation&);
  void (*finish_first_stage)(const PlanData&, Evaluation&, double h, double gamma_h);
  void (*finish_second_stage)(const PlanData&, Evaluation&, double h, double gamma_h);
  void (*add_displacements)(const PlanData&, Evaluation&);
  void (*add_velocities)(const PlanData&, Evaluation&);
};

// By InstructionSet; of one that this build lacks, the nearest below.
extern const Kernels* const kKernelTables[];
inline const Kernels& get_kernels(InstructionSet set) { return *kKernelTables[static_cast<int>(set)]; }
inline const Kernels& get_kernels(const PlanData& plan) { return get_kernels(plan.instruction_set); }

namespace baseline {
extern const Kernels kScalarKernels, kKernels;
}
namespace avx2 {
extern const Kernels kKernels;
}
namespace avx512 {
extern const Kernels kKernels;
}

}  // namespace unlatch
