// Evaluation: all that follows from a state, its inputs and the time, and can be computed again. WorkspaceData: an
// evaluation, the scratch memory of the search for events and the events that acted. Both are in memory that the caller
// gives.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "kernel/plan/plan_data.h"
#include "unlatch/state.h"
#include "unlatch/step_data.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Type of a mask: a pack is its own, a double has a bool.
template <class T>
struct MaskOf {
  using Type = T;
};
template <>
struct MaskOf<double> {
  using Type = bool;
};
// A joint at one stage, world axes.
template <class T>
struct JointFrameT {
  Vec3T<T> r_base, r_follower;       // from each body's origin to the follower's point, m
  Mat3T<T> n;                        // axes of the point–plane rows
  Mat3T<T> m;                        // axes of the rotation rows
  typename MaskOf<T>::Type crossed;  // a universal joint's row is about the normal of its cross
  Vec3T<T> displacement;             // of the follower's point from the base's, along n, m
  Vec3T<T> v_rel, w_rel;             // velocity of the point seen from the base; relative angular velocity
};
using JointFrame = JointFrameT<double>;

// The present modes of a group's joints, all lanes together.
struct GroupModes {
  RowSet freedoms, rows;      // FreedomBlocks and RowBlocks that some lane uses
  bool by_freedoms, by_rows;  // some lane is eliminated through its freedoms; some other lane
};

// Diagonal entries of Λ that belong to a row of a loop, for the decision whether it is independent.
struct RowEntry {
  double own;   // its own, before other rows of loops are eliminated
  double lost;  // of those rows, each as it enters this row's pivot: rounding is relative to own + lost
  double free;  // its own if nothing held its bodies
};

// One row of a joint that closes a loop.
struct LoopRow {
  std::int32_t loop, joint, non_tree, row, base, follower;  // loop, non_tree: the joint's place among those
  std::int32_t pivot;                                       // index of the row that is eliminated in this one's place
  Spatial on_base, on_follower;                             // unit wrenches at the bodies' origins
  RowEntry entry;
};

// A loop that is eliminated where it closes (PlanData::closures). Lanes: rows of its joint.
struct ClosureWork {
  std::int32_t count, rank;       // rows; independent ones
  std::int32_t most;              // at most so many are
  std::int32_t row[kRows];        // per lane: which it is
  std::int32_t order[kRows];      // lanes in the order of their pivots
  std::int32_t start_rank;        // independent rows at the beginning of the sub-step, which these are, in the order
  std::int32_t start_row[kRows];  // of their pivots
  double start_free[kRows];
  double inverse[kEight];                          // of the pivots, in that order
  double own[kEight], lost[kEight], free[kEight];  // as RowEntry's
  double target[kEight];                           // right-hand side, then what forward elimination leaves of it
  double mu[kEight];                               // multipliers
  // of the split of redundant reactions
  double scale[kEight], gradient[kEight], change[kEight];
  double z[kEight], u[kEight];  // of the pivot that is eliminated

  RowEntry get_entry(int lane) const { return {own[lane], lost[lane], free[lane]}; }
};

// Auxiliary states, State::auxiliary, in the stages of a sub-step.
struct Auxiliary {
  // computed by load_motion(), then by the stages (runge_kutta.h); modal ones also by the projections
  std::span<double> now;
  // computed by add_forces() and update_modal_rates()
  std::span<double> rate;  // 1/s
  // computed by begin_substep()
  std::span<double> start, first;  // at the beginning of the sub-step; their rates there
  // computed by the stages
  std::span<double> sum;  // of the rates of the stages so far, weighted as runge_kutta.h says
};

// A body with a mass law at one stage. A slope is per unit of the law's variable, s or kg.
struct VaryingBody {
  double mass, mass_slope;          // kg; its slope
  Vec3 centre_B, centre;            // centre of mass from the body's origin, body axes and world axes, m
  Vec3 centre_slope_B;              // of centre_B
  Sym3 inertia_B, inertia_slope_B;  // about the centre of mass, body axes, kg m²; its slope
};

// Cache of a load's law, a function of the time s since the load was switched on.
struct KeptProfile {
  double s, value;  // s, NaN while it is empty; N or N m
};

// A spring that is integrated implicitly, see kernel/elements/compliance.h.
struct CompliantSpring {
  double stiffness, damping;              // times its switch scale
  double first_rate, first_acceleration;  // of its coordinate, k1
  double second_place, second_rate;       // of its coordinate at the second stage, m or rad
};

// A closed pair of shapes of a contact, as the forces of an evaluation found it.
struct ClosedPair {
  Vec3 point, normal;  // midpoint of the witnesses, W, m; unit vector from the base to the follower
  Vec3 slip;           // velocity of the follower's material there, seen from the base's, across the normal, m/s
  double depth, rate;  // m; its rate, m/s
};

// Margins of a closed pair (geometry::PairMargins), and of its law: at the change of a sign the forces have a corner.
inline constexpr std::size_t kPairMargins = 6;
using PairFeature = std::array<double, kPairMargins>;

// What the friction of a closed pair of a rigid contact does.
enum class RigidMode : std::int32_t {
  kSmooth,  // it has no friction
  kSticks,  // the two rows hold
  kSlips,   // friction against the slip
  kCreeps,  // the slip begins or ends: friction against State::rigid_slips
};

// The row of a pair of a rigid contact that is closed, see kernel/elements/kinds/contact/rigid_row.h. With friction,
// two rows across the normal follow it: those of the slip, of the sphere seen from the other shape.
struct RigidRow {
  std::int32_t pair;             // into PlanData::contact_pairs
  std::int32_t base, follower;   // bodies
  Spatial on_base, on_follower;  // unit wrenches that part them, at the bodies' origins
  double gap, rate, bias;        // m; m/s; m/s²: of the gap's second derivative, what velocities alone decide
  double free;                   // mobility of the two bodies along the row, held by nothing, 1/kg
  std::int32_t tangent;          // 0: along the normal, m; 1, 2: of the slip, and `gap` is 0
  RigidMode mode;                // these of the row along the normal:
  double friction;               // μ
  double slip, slide[2];         // m/s; its direction in the two rows, 0 if it sticks or is smooth
  Vec3 along;                    // unit vector of the row, W, from the other shape to the sphere or across
};

// Scratch of kernel/integration/rigid_rows.cc. n: PlanData::rigid_pairs, and two more for each that has friction.
struct RigidScratch {
  std::span<RigidRow> rows;  // n, of which the first `count` hold
  std::int32_t count = 0;
  std::int32_t failed = kNone;          // the contact that failed, into PlanData::contacts
  bool wedged = false;                  // and why: its friction would outgrow what its normal force decides
  bool degenerate = false;              // or: its row is of no use, see calc_rigid_row()
  std::span<double> matrix;             // W H⁻¹ Wᵀ, n rows of n
  std::span<double> factor;             // n rows of n
  std::span<double> gram;               // n rows of n
  std::span<double> loads, forces;      // n: what each row still lacks; its force or impulse
  std::span<double> middle, pivots;     // n
  std::span<double> trial, residual;    // n, if there is friction
  double yield = 0;                     // of the latest impulses, see kernel/events/cone_impulses.h
  std::span<std::int32_t> independent;  // n
  std::span<Spatial> body_forces;       // per body: its SharedBlock::force without the rows' forces
};

// Scratch of kernel/solver/loops/redundant_rows.cc. k: rows of loops, t: of the tree's joints in loops.
struct SplitScratch {
  std::span<double> relation;            // k rows of k + t numbers
  std::span<double> matrix;              // square, of the smaller number of unknowns
  std::span<double> scales, loads;       // per independent row
  std::span<double> unknowns, shares;    // the larger number of unknowns; per redundant row
  std::span<std::int32_t> ring_columns;  // per joint of PlanData::ring_joints: its first row among those
};

// Groups of arrays in the order in which an evaluation computes them: each follows from those above it, the plan, and
// the modes, elements and commands of the instant.
struct Evaluation {
  std::span<const Place> places;  // PlanData::places

  // Bodies and joints of the tree, see blocks.h. Members of a block are computed by
  //   motion                                 load_motion(), then the stages and projections (runge_kutta.h); of markers
  //                                          update_markers()
  //   start, start_v_rate, start_w_rate      begin_substep()
  //   sum                                    the stages
  //   R, w_W, inertia                        update_kinematics()
  //   AppliedBlock                           update_loads()
  //   masks, carried axes, offset, crossed   load_modes()
  //   JointBlock; axes, arms, offset, bias   update_joints()
  //   force                                  update_forces()
  //   A, wrench, factors, U, beta            backward pass of the solver (tree_sweeps.h)
  //   acceleration, multipliers              its forward pass
  //   pivot of an implicit spring            begin_compliance()
  std::span<double> blocks;

  // computed by load_modes()
  std::span<GroupModes> modes;  // per group

  Auxiliary auxiliary;

  // computed by update_masses(), and their world axes by update_varying_kinematics()
  std::span<VaryingBody> varying;  // per body with a mass law

  // computed by update_loads()
  std::span<double> load_sizes;     // per load, N or N m per length of its direction; 0 if it is off
  std::span<KeptProfile> profiles;  // and its cache

  // computed by update_markers(), update_marker_biases(), add_flexible_forces() and the solver
  std::span<double> modal;  // ModalWork and MarkerWork of flexible bodies, see kernel/dynamics/flexible.h

  // computed by update_joints()
  std::span<JointFrame> non_tree_frames;  // per non-tree joint
  std::span<Spatial> non_tree_bias;       // right-hand side of its rows: along n and m, world axes

  // computed by update_coordinates(); per coordinate of a joint that is read
  std::span<double> coordinates;                       // displacement along n, m; angle about m, rad
  std::span<double> speeds;                            // their rates
  std::span<double> rotation_sines, rotation_cosines;  // its scratch, per rotation

  // computed by update_driving_laws() and update_other_laws()
  std::span<double> laws;                     // per law
  std::span<double> law_operands;             // as PlanLaws::operands
  std::span<double> law_places;               // as PlanLawStep::place
  std::span<std::int32_t> branches;           // per place that decides `if_less`: 1 if it is less
  std::span<std::int32_t> branches_at_start;  // those of the sub-step's beginning, which its stages keep
  std::span<double> middle_places;   // those in the middle of the latest sub-step, by its stages; none without corners
  std::span<TableExit> table_exits;  // per table

  // computed by update_forces(), if PlanData::air_corners has some; per aerodynamics, as there: the altitude of its
  // body
  std::span<double> altitudes;         // m; NaN while it is off
  std::span<double> middle_altitudes;  // as middle_places

  // computed by update_forces(), if some one-sided force has a table over its travel; per one-sided force
  std::span<double> travels;         // m or rad; NaN while it does not act, or has no table
  std::span<double> middle_travels;  // as middle_places

  // computed by begin_compliance() and begin_second_stage()
  std::span<CompliantSpring> compliant;  // as PlanData::compliant

  // computed by update_friction()
  std::span<double> friction_sizes;  // per friction, force or torque on the follower along its axis

  // computed by update_forces(); per pair of shapes of contacts
  std::span<ClosedPair> closed_pairs;  // of those that are closed and on

  // computed by update_forces() for closed pairs, by update_open_pairs() for open ones
  std::span<double> pair_distances, pair_rates;  // of those that are on, m; m/s, of open ones alone, 0 far apart

  // computed by update_guards(), of closed pairs of compliant contacts that are on; of others not a number
  std::span<PairFeature> pair_features;

  // computed by solve_rigid_rows(), with the accelerations; per pair of shapes, if there are rigid contacts
  std::span<double> pair_forces;  // of closed pairs of rigid contacts, N
  // likewise, if some have friction: on the follower, N; ≥ 0 where it begins or ends to stick, N or m/s
  std::span<Vec3> pair_frictions;
  std::span<double> pair_slides;
  RigidScratch rigid;

  // computed by the solver's forward pass
  MultiplierView multipliers;

  // computed by update_loop_rows(); per row of the joints that close loops, k in all
  std::span<LoopRow> loop_rows;
  std::span<std::int32_t> loop_ranges;  // per loop: its first row; and the end
  std::int32_t loop_count = 0;          // rows that are active
  // computed by update_loop_matrix() and factor_loop_matrix()
  std::span<double> loop_matrix;    // Λ, then its factor: lower triangle, PlanData::loop_columns a row
  std::span<double> loop_loads;     // wrenches on their way to the root
  std::span<double> loop_replies;   // of the pivot that is eliminated: what each wrench moves there
  std::span<double> loop_column;    // of the pivot of Λ that is eliminated
  std::int32_t loop_redundant = 0;  // of the active rows, those that follow from the others
  // computed by solve_loop_rows()
  std::span<double> loop_solution;  // k
  // computed by LoopReactions
  std::span<Spatial> loop_forces;  // per body: its SharedBlock::force without the reactions
  // computed by split_redundant_rows()
  SplitScratch split;
  std::span<double> split_matrix, split_columns;  // where loops are eliminated where they close
  // computed by LoopClusters: loops that are eliminated where they close
  std::span<ClosureWork> closures;
  std::span<double> cluster_matrix;   // Λ, then its factor
  std::span<double> cluster_columns;  // wrenches at the nodes, and their products with the pivots there

  // computed by update_guards()
  std::span<double> guards;  // per event, then per pair of shapes of contacts
  // computed by update_readings()
  std::span<double> sensors;     // in the order of the model's sensors, each with its width
  std::span<double> quantities;  // in the order of the model's quantities

  Spatial get_acceleration(int body) const {
    return read(blocks.data(), places[static_cast<std::size_t>(body)], &SharedBlock<double>::acceleration);
  }
};

// The evaluation with which a step ends, and the state that it is of. The next step begins with it if it gets that very
// state, byte by byte; the bits are the same as from a new evaluation.
struct FinalEvaluation {
  Evaluation evaluation;
  State state;                 // how far the step has got; between steps, its end, of which the outputs are
  std::span<double> commands;  // per channel: of the step that ended
  bool valid = false;          // between steps: all of `evaluation` is of `state` and `commands`

  bool is_of(const State& other) const {
    const std::span<const std::byte> mine = state.get_bytes(), theirs = other.get_bytes();
    return valid && std::memcmp(theirs.data(), mine.data(), mine.size()) == 0;
  }
  bool has_commands(std::span<const double> other) const {
    return other.size() == commands.size() &&
           (other.empty() || std::memcmp(other.data(), commands.data(), other.size_bytes()) == 0);
  }
  // Now `evaluation` is of `state`, with these commands.
  void keep(std::span<const double> latest) {
    std::copy_n(latest.begin(), std::min(latest.size(), commands.size()), commands.begin());
    valid = true;
  }
};

// The part for pairs of shapes of a list with one number per guard; it follows the part for events.
template <class Number>
std::span<Number> get_pair_guards(const PlanData& plan, std::span<Number> guards) {
  return guards.subspan(plan.events.size());
}

// Scratch of one step: nothing of it outlives the step.
struct EventSearch {
  // per event, then per pair of shapes of contacts
  std::span<double> guards_low, guards_high;  // at both ends of the bracket in which an event is located
  std::span<double> guards_middle;            // at the end of the bracket that was replaced last
  std::span<double> tolerances;               // a guard within this of zero acts together with the located one
  std::span<double> rates_low, rates_high;    // per pair: Evaluation::pair_rates at both ends of the sub-step
  std::span<double> places_low;               // Evaluation::law_places at the start of the sub-step
  std::span<double> altitudes_low;            // Evaluation::altitudes at the start of the sub-step
  std::span<double> travels_low;              // Evaluation::travels at the start of the sub-step
  std::span<PairFeature> features_low;        // Evaluation::pair_features at the start of the sub-step
  std::int32_t corners;                       // of laws, travels and the air at which this step has been split
  std::int32_t features;                      // changes of features at which it has been split
  std::span<std::int64_t> acting;             // per event; 1: acts in this round
  std::span<double> stack;                    // of values, for the evaluation of one guard
  std::span<std::int64_t> rigid;              // per pair of shapes, if there are rigid contacts: what it did at this
                                              // instant, see kernel/events/rigid_pairs.h
  std::span<std::int64_t> rigid_returns;      // likewise: how often it has come back soon in this step
  std::span<double> rigid_lifts;              // likewise: when it opened last in this step, s; else −∞
};

// Events that acted in a step. StepReport has views of them, which hold until the next step.
struct EventRecord {
  std::span<FiredEvent> fired;
  std::span<EventAudit> audits;
  std::int32_t fired_count = 0, audit_count = 0;
  std::int32_t change_count = 0;  // pairs that closed or opened in this step
};

struct WorkspaceData {
  FinalEvaluation kept;
  EventSearch search;
  EventRecord events;
  std::span<double> exact;         // per guard, a tolerance of zero; written by the constructor alone
  std::span<std::uint8_t> unread;  // per sensor, not 0: nobody reads it
};

inline WorkspaceData& get_data(const Workspace& workspace) noexcept { return *workspace.data_; }

}  // namespace unlatch
