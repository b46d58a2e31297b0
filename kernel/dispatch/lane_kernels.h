// The stages of a step that work on lanes, compiled once for each instruction set; the plan holds those of its
// processor. What each of them reads and writes are rows of Workspace::lanes (lanes.h).
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

// What the joints impose on the way down the tree.
enum class BiasKind : std::int32_t {
  kAcceleration,  // right-hand side of the rows for accelerations
  kVelocity,      // for a velocity correction: the rows' velocities, reversed
  kPosition,      // for a displacement: the rows' gaps, reversed
};

// What stands on the right of M a = F + Gᵀ λ.
enum class Source : std::int32_t {
  kForces,   // the applied forces
  kNothing,  // corrections and impulses
  kGiven,    // what stands in the rows of the accelerations, which it is lost from
};

struct Sweep {
  Source source = Source::kForces;
  bool biased = true;       // false: the rows' right-hand sides count as zero
  bool multipliers = true;  // recover them on the way down
};

struct LaneKernels {
  Lanes lanes;
  // Rotation, angular velocity and inertia in world axes, from pose and velocity.
  void (*update_kinematics)(const Plan&, Workspace&);
  // The angular velocity alone, where poses have not changed since.
  void (*update_rates)(const Plan&, Workspace&);
  // Weight, gyroscopic torque and loads fixed in the bodies, from poses and kinematics.
  void (*init_forces)(const Plan&, Workspace&);
  // Arms, axes, slips and what the joint imposes, for joints of the tree; needs kinematics. For accelerations also what
  // init_forces() does.
  void (*update_joints)(const Plan&, Workspace&, BiasKind);
  // The same for accelerations, where neither poses nor modes have changed since.
  void (*renew_joints)(const Plan&, Workspace&);
  // Sines and cosines to angles, see lane_angles.h.
  void (*calc_angles)(double* sines, const double* cosines, std::size_t count);
  // Leaves to root. Returns kNone, or the node whose pivot vanished.
  int (*factor_and_reduce)(const Plan&, Workspace&, const Sweep&);
  // Leaves to root again with another right-hand side.
  void (*reduce)(const Plan&, Workspace&, const Sweep&);
  // Root to leaves: accelerations, and multipliers if asked for.
  void (*substitute)(const Plan&, Workspace&, const Sweep&);
  // Λ of the joints that close loops, for ws.loop_rows, with the latest factor; what row `pivot` explains, taken out of
  // the rows after it.
  void (*reduce_loops)(const Plan&, Workspace&);
  void (*downdate_loops)(const Plan&, Workspace&, int pivot);
  // What moves bodies leaves their kinematics as well, except add_velocities() their inertia, which stays.
  // Runge–Kutta: keeps pose, velocity and their rates as the beginning of a sub-step.
  void (*keep_start)(const Plan&, Workspace&);
  // From the beginning: the sum starts with `weight` of its rates, the pose goes `h` seconds along them.
  void (*begin_stages)(const Plan&, Workspace&, double weight, double h);
  // Adds `weight` of the present rates to the sum; the pose goes `h` seconds from the beginning along these rates.
  void (*advance_stage)(const Plan&, Workspace&, double weight, double h);
  // The same, but the pose goes `h` seconds from the beginning along the sum.
  void (*finish_stages)(const Plan&, Workspace&, double weight, double h);
  // The stages of a sub-step with implicit elements, see compliance.h: back to the beginning; from there to the second
  // stage, with the first one's solution; from there to the end, with the second one's. `lead`: γ h.
  void (*restart)(const Plan&, Workspace&);
  void (*finish_first_stage)(const Plan&, Workspace&, double h, double lead);
  void (*finish_second_stage)(const Plan&, Workspace&, double h, double lead);
  // Applies the latest solution as a displacement, or as a change of velocity.
  void (*add_displacements)(const Plan&, Workspace&);
  void (*add_velocities)(const Plan&, Workspace&);
};

// Those of the given instruction set, which must be supported.
const LaneKernels& get_kernels(Lanes lanes);

namespace baseline {
extern const LaneKernels kScalarKernels, kKernels;
}
namespace avx2 {
extern const LaneKernels kKernels;
}
namespace avx512 {
extern const LaneKernels kKernels;
}

}  // namespace unlatch
