// Plan: the model compiled for one step size. Numbers in flat arrays in the order in which the step reads them, names
// and Eigen types left behind. Never changes; any number of threads may step with one plan.
//
// One elimination order serves every structure phase: it is that of the full tree, and a joint's mode only decides
// which of its six rows hold. Phases therefore do not multiply.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "kernel/math/spatial.h"
#include "kernel/plan/lanes.h"
#include "unlatch/math.h"
#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch {

struct LaneKernels;

// Instruction sets: numbers that one instruction works on.
enum class Lanes { kAuto, kScalar, kTwo, kFour, kEight };
bool is_supported(Lanes lanes);     // by this build on this processor
const char* get_name(Lanes lanes);  // "scalar", "sse2" or "neon", "avx2", "avx512"; of kAuto, what it stands for

struct PlanOptions {
  double dt = 0.001;           // s, > 0
  int max_splits = 8;          // sub-steps that events may cut one step into, at most; later ones act at the next tick
  int root = kNone;            // body at the root of its tree; by default the one that makes the tree shallowest
  Lanes lanes = Lanes::kAuto;  // how wide to compute: for tests and benches, every choice gives the same bits
};

// A body in the elimination order: parents before children, so that forward is root to leaves and backward the reverse.
struct PlanNode {
  std::int32_t body;
  std::int32_t parent;  // node, or kNone for the root of a tree
  std::int32_t joint;   // to the parent, or to the ground for a root that is held; kNone for a root that is not
  std::int8_t side;     // +1: this body is the joint's follower; −1: its base
  bool leaf;            // nothing is beyond it, and its mass is constant: its block is diag(mass, inertia)
};

struct PlanBody {
  double mass;  // kg; of a body with a mass law 0, the law adds it
  BodyState initial;
  std::int32_t varying = kNone;   // into Plan::varying
  std::int32_t flexible = kNone;  // into Plan::flexible: of a flexible body, and of its markers
};

// A flexible body, see flexible.h.
struct PlanFlexible {
  std::int32_t body, modes;
  std::int32_t first_marker, markers;  // into Plan::markers
  std::int32_t extras;                 // into State::extras: its modal coordinates, then their rates
  std::int32_t numbers;                // into Plan::modal: invariants, stiffness and damping
  std::int32_t work;                   // into Workspace::modal
  std::int32_t inboard;                // marker that it is held by, into Plan::markers; kNone for a root
  bool implicit;                       // some mode swings faster than the step resolves
  double mass;                         // kg
  Sym3 inertia;                        // undeformed, body axes, kg m²
};
struct PlanMarker {
  std::int32_t body, flexible;
  std::int32_t numbers;  // into Plan::modal: Φ, then Ψ, three per mode
  Vec3 position;         // undeformed, from the body's origin, body axes, m
  bool bare;             // no joint hangs on it
};

// A node that the wrenches of loops pass on their way to the root, see loop_nodes.h and lane_loops.h.
struct LoopNode {
  std::int32_t node, group;
  LaneSlot slot;                 // of its body
  std::int32_t loads;            // row of Workspace::loop_loads where those at its body begin
  std::int32_t parent_loads;     // and those at its parent's; the same if it is the first to come there; kNone: a root
  std::int32_t first_end, ends;  // of loops at its body: into Plan::loop_ends
  std::int32_t modal;            // row where the modal loads of its flexible body begin
  std::int32_t marker;           // into Plan::markers, of a marker
  bool opens;                    // nothing comes to it from beyond
};
// One side of a joint that closes a loop.
struct LoopEnd {
  std::int32_t loop;  // into Plan::loops
  bool follower;
};

// A spring that is integrated implicitly, see compliance.h.
struct PlanCompliant {
  std::int32_t spring;               // into Plan::joint_springs
  std::int32_t pivot, acceleration;  // where Workspace::lanes has what it adds to its freedom's pivot, and that
                                     // freedom's acceleration
  double side;                       // of the joint's child
};

struct MassKnot {
  double at, mass;
  Vec3 centre;
  Sym3 inertia;
};
struct PlanVarying {
  std::int32_t body, first, count;  // of its knots
  bool by_burnt, jet_damping;
  Vec3 exit;
};

// Points and axes of a joint of the tree are in the constants of its lane.
struct PlanJoint {
  Quat rotation_base, rotation_follower;  // rotation frame in each body's axes
  std::int32_t base, follower;            // bodies; base may be kGround
  std::int32_t first_mode;                // into Plan::modes
  std::int32_t mode;                      // at first
  bool universal;
  std::uint8_t rotation_row = kAxes;  // of a joint of the tree: where the rotation rows' axes are in the child's lane
  std::int32_t child = kNone;         // likewise: the body that it holds to its parent
  std::int32_t loose = kNone;         // of any other joint: its place in Plan::loose_joints
};

// A joint that is no edge of the tree.
struct PlanLooseJoint {
  std::int32_t joint;
  Vec3 point_base, point_follower;
  Mat3 axes, rotation_axes;  // joint frame and rotation frame, base axes
};

struct PlanCoordinate {
  std::int32_t joint, row;
  // of a rotation: its initial value, and the two axes of the rotation frame across its own, in each body's axes
  double initial = 0;
  Vec3 across_base[2]{}, across_follower[2]{};
  // of a displacement in a joint of the tree: where Workspace::lanes has it, its axis, and the velocity that it changes
  // by; numbers of a vector are `stride` apart
  std::int32_t gap = kNone, axis = kNone, slip = kNone, stride = 1;
};

struct PlanProfile {
  Profile::Kind kind;
  double value, initial, final, tau;
  std::int32_t first, count;  // kTable: into Plan::knots; kHarmonic: into Plan::harmonics
};

struct PlanLoad {
  std::int32_t body, element, profile, channel;
  bool world;            // it keeps its direction in the world, else in the body
  bool first;            // of the latter: the first on its body
  std::int32_t applied;  // likewise: where Workspace::lanes sums them, kOctet apart; kNone for one in the world
  Vec3 point;            // of a force in the world, body axes
  Spatial wrench;        // of size 1, in its axes; in the body at the origin, in the world at the point
  double length;         // of the direction
  double consumption;    // kg per N s
  std::int32_t varying;  // into Plan::varying: what burns it
};

struct PlanPointSpring {
  std::int32_t base, follower, element;
  bool push_only;
  Vec3 point_base, point_follower;
  double stiffness, damping, free_length;
};

struct PlanJointSpring {
  std::int32_t joint, axis, element;
  std::int32_t coordinate;  // into Plan::coordinates
  double effort, stiffness, damping, rest;
  std::int32_t compliant;  // into Plan::compliant, kNone if it is integrated explicitly
};

struct PlanPlaneTorsion {
  std::int32_t base, follower, element;
  Vec3 normal_base, axis_follower;
  double stiffness, damping;
};

// Guards in postfix order: a condition's parts stand before it.
struct PlanCondition {
  Condition::Kind kind;
  std::int32_t subject, axis, part_count;  // subject: of one that reads a coordinate, into Plan::coordinates
  double threshold;
  bool below;
  std::int32_t first_mode, multiplier;  // of a reaction: of its joint in Plan::modes; where Workspace::lanes has it
};

struct PlanEvent {
  std::int32_t first_condition, condition_count, first_action, action_count;
  std::int32_t flat_parts;  // the first conditions that must all hold, where the guard is nothing else; otherwise 0
  double delay;
  bool repeat;
  bool by_time;  // the whole guard is "t ≥ T", which needs no search
};

struct PlanSensor {
  Sensor::Kind kind;
  std::int32_t subject;  // of one that reads a coordinate, into Plan::coordinates
  std::int32_t first;    // into Workspace::sensors
  Vec3 point;
};

struct Knot {
  double time, value;
};

class Plan {
 public:
  PlanOptions options;
  std::uint64_t hash = 0;  // of everything below: two plans with one hash step alike

  std::vector<PlanNode> nodes;
  std::vector<PlanBody> bodies;
  std::vector<PlanJoint> joints;
  std::vector<RowSet> modes;
  std::vector<std::int32_t> loops;   // joints that close a loop over the tree
  std::vector<LoopNode> loop_nodes;  // children before parents
  std::vector<LoopEnd> loop_ends;
  std::int32_t loop_rows = 0, loop_columns = 0;  // that the loops' joints hold at most; the same, padded for packs
  std::int32_t loop_load_rows = 0;               // of Workspace::loop_loads, before its scratch
  std::int32_t loop_modal_rows = 0;              // of these, the first, of modal coordinates
  std::vector<PlanCoordinate> coordinates;       // that somebody reads, or their rates
  std::int32_t driven_coordinates = 0;           // of these, the first, springs do, so that every stage needs them
  std::int32_t turn_count = 0;                   // rotations among them all
  std::vector<PlanLooseJoint> loose_joints;      // joints that are no edge of the tree: those, and ones that never hold

  // lanes, see lanes.h
  std::vector<LaneOctet> octets;
  std::vector<LaneGroup> groups;             // parents before children
  std::vector<std::int32_t> own_beginnings;  // those whose blocks no child begins, see LaneGroup::begins
  std::vector<std::int32_t> lane_nodes;      // per lane: its node, or kNone
  std::vector<LaneSlot> lane_parents;        // per lane: where its parent is
  std::vector<RowSet> compliant_axes;        // per joint: axes with implicit springs
  std::vector<double> body_constants;        // blocks of BodyConstant rows,
  std::vector<double> joint_constants;       // of JointConstant rows,
  std::vector<double> solver_constants;      // and of SolverConstant rows
  std::vector<LaneSlot> body_slots;          // per body: its place and its joint's
  std::vector<LaneColumn> multipliers;       // per joint: the six of them
  std::int32_t lane_numbers = 0;             // size of Workspace::lanes
  const LaneKernels* kernels = nullptr;      // the stages of the step, compiled for this processor

  std::vector<PlanVarying> varying;
  std::vector<MassKnot> mass_knots;
  std::vector<PlanFlexible> flexible;
  std::vector<PlanMarker> markers;  // those of one flexible body together
  std::vector<double> modal;
  std::int32_t modal_work = 0;         // size of Workspace::modal
  std::vector<double> initial_extras;  // coordinates beyond the bodies: burnt by each of `varying`, then modal ones
  std::vector<PlanCompliant> compliant;
  bool rigid = true;  // no body bends or changes its mass: most of the above is empty

  Vec3 gravity{};
  double mu = 0;
  Vec3 mu_centre{};
  std::vector<PlanLoad> loads;
  bool commanded_loads = false;          // some load's size is a command's
  std::vector<std::int32_t> busy_loads;  // of these, those in the world, and those that burn something
  std::vector<PlanPointSpring> point_springs;
  std::vector<PlanJointSpring> joint_springs;
  std::vector<PlanPlaneTorsion> plane_torsions;
  std::vector<PlanProfile> profiles;
  std::vector<Knot> knots;
  std::vector<Profile::Harmonic> harmonics;
  std::vector<double> element_scales;  // initial switch scale per element: 0 or 1

  std::vector<PlanCondition> conditions;
  std::vector<Action> actions;
  std::vector<PlanEvent> events;
  std::vector<std::int32_t> repeating_events;
  std::vector<std::int32_t> timed_events;  // that are due at a known time: by their guard, or after a delay
  bool commanded_events = false;           // a command decides some guard, itself or by what it makes of the reactions
  std::vector<PlanSensor> sensors;
  std::int32_t sensor_count = 0;  // values, all sensors' components counted
  std::int32_t signal_count = 0;
  std::int32_t channel_count = 0;
  std::int32_t guard_depth = 0;  // values that evaluating the deepest guard keeps at once

  std::size_t get_state_bytes() const;
  std::size_t get_workspace_bytes() const;
  RowSet get_rows(int joint, std::int64_t mode) const {
    return modes[static_cast<std::size_t>(joints[static_cast<std::size_t>(joint)].first_mode + mode)];
  }
};

struct PlanResult {
  std::optional<Plan> plan;  // absent if there are errors
  std::vector<ModelError> errors;
};

// Validates and compiles; O(n log n), for sorting. Allocates; nothing after it does.
PlanResult compile_plan(const Model& model, const PlanOptions& options);

}  // namespace unlatch
