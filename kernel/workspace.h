// Workspace: everything that the step can recompute, grouped by the stage that writes it. Scratch, one per thread; its
// content before a step does not matter. Like the state it lives in memory that the caller gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernel/articulated.h"
#include "kernel/math.h"
#include "kernel/model.h"
#include "kernel/state.h"

namespace unlatch {

class Plan;
struct FiredEvent;
struct EventAudit;

// A body at one stage. Computed by update_kinematics().
struct BodyKinematics {
  Mat3 R;  // R_WB
  Vec3 w;  // w_WB in world axes, rad/s
  Sym3 J;  // inertia in world axes, kg m²
};

// A joint at one stage, world axes. Computed by update_joint_frames().
struct JointFrame {
  Vec3 r_base, r_follower;  // from each body's origin to the follower's point, m
  Mat3 n;                   // axes of the point–plane rows
  Mat3 m;                   // axes of the rotation rows
  bool crossed;             // a universal joint's row about the normal of its cross
  Vec3 displacement;        // of the follower's point from the base's, along n, m
  Vec3 v_rel, w_rel;        // velocity of the point seen from the base; relative angular velocity, world axes
};

// One eliminated freedom of a joint. Computed by factor(), `beta` by solve().
struct Pivot {
  Spatial s;       // its direction at the child's origin
  Spatial U;       // A s
  double inverse;  // 1 / sᵀ A s
  double beta;     // sᵀ b
};

// The block LDLᵀ at one node. Computed by factor(), the loads by solve().
struct NodeFactor {
  Articulated A;         // of the body and all beyond it
  Vec3 offset;           // from the parent's origin, or the ground's, m
  Spatial bias;          // what the joint imposes besides its freedoms, at the body's origin
  Spatial load;          // force and torque on the body and all beyond it
  RowSet rows;           // that hold it to its parent or to the ground; 0: it moves freely
  std::int8_t freedoms;  // pivots in use; 0 where no row holds
  union {
    Pivot pivots[kRows];  // where rows hold
    FreeFactor free;      // where none does
  };
};

// One row of a joint that closes a loop. Computed by factor_loops().
struct LoopRow {
  std::int32_t joint, row, base, follower;
  std::int32_t pivot;            // index of the row that is eliminated in this one's place
  Spatial on_base, on_follower;  // unit wrenches at the bodies' origins
  double own;                    // its diagonal entry of Λ
};

// Derivative of a BodyState.
struct BodyRate {
  Vec3 p;
  Quat q;
  Vec3 v, w;
};

struct Workspace {
  Workspace() = default;
  // `memory`: at least plan.get_workspace_bytes(), aligned to 64.
  Workspace(const Plan& plan, std::span<std::byte> memory) noexcept;

  // per body, model order
  std::span<BodyKinematics> kinematics;
  std::span<Spatial> forces;         // applied force and torque at the body origin, gyroscopic torque included; N, N m
  std::span<Spatial> accelerations;  // of the latest solve; m/s², rad/s², world axes
  std::span<BodyRate> rates[4];      // of the stages of the Runge–Kutta step

  // per joint, model order
  std::span<JointFrame> frames;
  std::span<Spatial> bias;        // right-hand side of the rows: along n and m, world axes
  std::span<double> multipliers;  // 6 per joint in the order of Row, 0 for rows that do not hold; N, N m
  std::span<double> coordinates;  // 6 per joint that is read: displacement along n, m; angle about m, rad
  std::span<double> speeds;       // 6 per joint: their rates

  // per node of the elimination order
  std::span<NodeFactor> factors;

  // per row of the joints that close loops, k in all
  std::span<LoopRow> loop_rows;
  std::span<Spatial> loop_columns;     // accelerations of all bodies per unit multiplier, k × bodies
  std::span<double> loop_multipliers;  // of the tree's joints, likewise, k × 6 joints
  std::span<double> loop_matrix;       // Λ, then its factor, k × k
  std::span<double> loop_solution;     // k
  std::int32_t loop_count = 0;         // rows that are active
  std::int32_t loop_redundant = 0;     // of these, rows that follow from the others
  std::int32_t loop_most = 0;          // as many of them as factor_loops() may take for independent

  // states: a stage of the Runge–Kutta step, the end of a trial sub-step, and how far the step has got
  State stage, trial, accepted;

  // per event
  std::span<double> guards;                   // at the latest evaluation
  std::span<double> guards_low, guards_high;  // at both ends of the bracket in which an event is located
  std::span<double> guards_middle;            // at its first iterate
  std::span<double> tolerances;               // how far below zero a guard may stand and still count as reached
  std::span<std::int64_t> acting;             // 1: acts in this round
  std::span<double> stack;                    // evaluates one guard
  std::span<FiredEvent> fired;
  std::span<EventAudit> audits;
  std::int32_t fired_count = 0, audit_count = 0;

  // outputs of the state at the end of the step
  std::span<double> sensors;  // in the order of the model's sensors, each with its width
};

}  // namespace unlatch
