// Workspace: everything that the step can recompute, grouped by the stage that writes it. Scratch, one per thread; its
// content before a step does not matter. Like the state it lives in memory that the caller gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernel/math/spatial.h"
#include "kernel/plan/lanes.h"
#include "unlatch/math.h"
#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch {

class Plan;
struct FiredEvent;
struct EventAudit;

// A body at one stage. Computed by the kernels' update_kinematics.
struct BodyKinematics {
  Mat3 R;  // R_WB
  Vec3 w;  // w_WB in world axes, rad/s
  Sym3 J;  // inertia in world axes, kg m²
};

// A joint at one stage, world axes. Computed by the kernels' update_joints, or by update_joints() in kinematics.h.
struct JointFrame {
  Vec3 r_base, r_follower;  // from each body's origin to the follower's point, m
  Mat3 n;                   // axes of the point–plane rows
  Mat3 m;                   // axes of the rotation rows
  bool crossed;             // a universal joint's row about the normal of its cross
  Vec3 displacement;        // of the follower's point from the base's, along n, m
  Vec3 v_rel, w_rel;        // velocity of the point seen from the base; relative angular velocity, world axes
};

// What lies in the lanes as the bodies of the model: index it by the body.
template <class T, T (*kRead)(const double* lanes, LaneSlot slot)>
class BodyView {
 public:
  BodyView() = default;
  BodyView(const double* lanes, std::span<const LaneSlot> slots) : lanes_(lanes), slots_(slots) {}
  std::size_t size() const { return slots_.size(); }
  T operator[](std::size_t body) const { return kRead(lanes_, slots_[body]); }

 private:
  const double* lanes_ = nullptr;
  std::span<const LaneSlot> slots_;
};
Spatial read_acceleration(const double* lanes, LaneSlot slot) noexcept;
BodyKinematics read_kinematics(const double* lanes, LaneSlot slot) noexcept;

// The multipliers of all joints, six each in the order of Row: 0 for rows that do not hold; N, N m.
class MultiplierView {
 public:
  MultiplierView() = default;
  MultiplierView(double* lanes, std::span<const LaneColumn> joints) : lanes_(lanes), joints_(joints) {}
  std::size_t size() const { return joints_.size() * kRows; }
  double operator[](std::size_t i) const { return get(i / kRows, i % kRows); }
  double& get(std::size_t joint, std::size_t row) const {
    return lanes_[joints_[joint].first + static_cast<std::ptrdiff_t>(row) * joints_[joint].stride];
  }

 private:
  double* lanes_ = nullptr;
  std::span<const LaneColumn> joints_;
};

// One row of a joint that closes a loop. Computed by factor_loops().
struct LoopRow {
  std::int32_t joint, loose, row, base, follower;  // loose: the joint's place among those that are no edge
  std::int32_t pivot;                              // index of the row that is eliminated in this one's place
  Spatial on_base, on_follower;                    // unit wrenches at the bodies' origins
  double own;                                      // its diagonal entry of Λ
  double free;                                     // what that would be if nothing held its bodies
};

// Coordinates beyond the bodies as the stages of a step take them, see extras.h.
struct Extras {
  std::span<double> now, rate;  // at the stage, 1/s
  std::span<double> start, first,
      sum;  // at the beginning of the sub-step, their rates there, weighted sum of the rates
};

// A body with a mass law at one stage. Computed by update_masses() and update_varying_kinematics().
struct VaryingBody {
  double mass, mass_slope;          // kg; per unit of the law's variable
  Vec3 centre_B, centre;            // centre of mass from the body's origin, body axes and world axes, m
  Sym3 inertia_B, inertia_slope_B;  // about the centre of mass, body axes, kg m²; per unit of the law's variable
};

// The value of a load's law at the latest time at which it was needed; see loads.h.
struct KeptProfile {
  double s, value;  // seconds after it began; N or N m
};

// Where a step with implicit elements stands, see compliance.h.
enum class ImplicitStage : std::int32_t { kOff, kFirst, kSecond };
struct Implicit {
  ImplicitStage stage = ImplicitStage::kOff;
  double h = 0, lead = 0;  // s; lead: γ h
};
// A spring that is integrated implicitly. Computed by begin_compliance() and keep_first_stage().
struct CompliantSpring {
  double stiffness, damping;              // times its switch scale
  double first_rate, first_acceleration;  // of its coordinate, k1
  double second_place, second_rate;       // of its coordinate at the second stage, m or rad
};

struct Workspace {
  Workspace() = default;
  // `memory`: at least plan.get_workspace_bytes(), aligned to 64. Keeps spans of the plan's arrays: the plan, or what
  // it has been moved to, must outlive it.
  Workspace(const Plan& plan, std::span<std::byte> memory) noexcept;

  // the bodies and the joints of the tree, see lanes.h
  std::span<double> lanes;
  std::span<LanePhase> phases;      // per group
  std::span<const LaneSlot> slots;  // Plan::body_slots
  BodyView<BodyKinematics, read_kinematics> kinematics;
  BodyView<Spatial, read_acceleration> accelerations;  // of the latest solve; m/s², rad/s², world axes
  MultiplierView multipliers;

  Extras extras;
  std::span<KeptProfile> profiles;       // per profile
  std::span<double> load_sizes;          // per load, N or N m per length of its direction; 0 if it is off
  double loads_time = 0;                 // s: when they were so, see loads.h
  std::span<VaryingBody> varying;        // per body with a mass law
  std::span<double> modal;               // of flexible bodies and their markers, see flexible.h
  std::span<CompliantSpring> compliant;  // as Plan::compliant
  Implicit implicit;

  // per coordinate of a joint that is read
  std::span<double> coordinates;  // displacement along n, m; angle about m, rad
  std::span<double> speeds;       // their rates
  // per rotation that is read: sine, later the angle, and cosine, times any number
  std::span<double> turn_sines, turn_cosines;

  // per joint that is no edge of the tree
  std::span<JointFrame> loose_frames;
  std::span<Spatial> loose_bias;  // right-hand side of the rows: along n and m, world axes

  // per row of the joints that close loops, k in all
  std::span<LoopRow> loop_rows;
  std::span<std::int32_t> loop_ranges;  // per loop: its first row; and the end
  std::span<double> loop_matrix;        // Λ, then its factor: lower triangle, Plan::loop_columns a row
  std::span<double> loop_loads;         // wrenches on their way to the root, see lane_loops.h, and its scratch
  std::span<double> loop_solution;      // k
  std::int32_t loop_count = 0;          // rows that are active
  std::int32_t loop_redundant = 0;      // of these, rows that follow from the others
  std::int32_t loop_most = 0;           // as many of them as factor_loops() may take for independent

  State accepted;        // how far the step has got; what it tries from there is in the lanes
  bool settled = false;  // no step is under way, and `accepted` is what the lanes and all of the above are of

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
