// PlanData: the model compiled for one step size. Numbers in flat arrays in the order in which the step reads them,
// without names and Eigen types. Never changes; any number of threads may step with one plan. One long file of plain
// structs: the image of a plan has them all.
//
// One elimination order serves all modes of the joints: it is that of the full tree, and a mode only decides which of
// its joint's six rows hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kernel/environment/environment.h"
#include "kernel/math/index.h"
#include "kernel/model/one_sided_law.h"
#include "kernel/plan/lanes.h"
#include "kernel/plan/list_kinds.h"
#include "kernel/plan/plan_laws.h"
#include "unlatch/cords.h"
#include "unlatch/geometry.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// --- Tree ------------------------------------------------------------------------------------------------------------

struct PlanBody {
  double mass;  // kg; 0 of a body with a mass law, a flexible body or a marker, whose mass is added separately
  BodyState initial;
  std::int32_t varying = kNone;   // into PlanData::varying
  std::int32_t flexible = kNone;  // into PlanData::flexible: of a flexible body, and of its markers
};

// Points and axes of a joint of the tree are in its group's JointConstants.
struct PlanJoint {
  Quat rotation_base, rotation_follower;  // rotation frame in each body's axes
  std::int32_t base, follower;            // bodies; base may be kGround
  std::int32_t first_mode;                // into PlanData::modes
  std::int32_t mode;                      // at first
  bool universal;
  std::int32_t child = kNone;     // of a joint of the tree: the body that it holds to its parent
  std::int32_t group = kNone;     // likewise: its group
  std::int32_t non_tree = kNone;  // of any other joint: its place in PlanData::non_tree_joints
  // Square roots of the stiffnesses that redundant reactions are shared by, see kernel/solver/redundant_rows.h.
  double share = 1, turning_share = 1;  // of a point–plane row; of a rotation row, m
};

// A joint that is no edge of the tree: it closes a loop, or never holds.
struct PlanNonTreeJoint {
  std::int32_t joint;
  Vec3 point_base, point_follower;
  Mat3 axes, rotation_axes;  // joint frame and rotation frame, base axes
  Vec3 follower_y;           // y of the rotation frame, follower axes
};

// A node that the wrenches of loops pass on their way to the root, see loop_nodes.h and kernel/solver/loop_columns.h.
struct LoopNode {
  std::int32_t node, group;
  Place place;                   // of its body
  std::int32_t loads;            // row of Evaluation::loop_loads where those at its body begin
  std::int32_t parent_loads;     // and those at its parent's; the same if it is the first to come there; kNone: a root
  std::int32_t first_end, ends;  // of loops at its body: into PlanData::loop_ends
  std::int32_t modal;            // row where the modal loads of its flexible body begin
  std::int32_t marker;           // into PlanData::markers, of a marker
  bool opens;                    // nothing comes to it from outboard
};
// Rows of Evaluation::loop_loads behind the loads.
inline constexpr std::size_t kLoopScratch = 7;

// One side of a joint that closes a loop.
struct LoopEnd {
  std::int32_t loop;  // into PlanData::loops
  bool follower;
};

// The nodes that a loop's wrenches pass from its two bodies to where the ways meet, that one excluded, see
// loop_paths.h: into PlanData::path_nodes.
struct LoopPath {
  std::int32_t first, base_first, end;  // from the follower; from the base; behind both
  std::int32_t mesh;                    // into PlanData::meshes
};
struct PathNode {
  std::int32_t loop_node;   // into PlanData::loop_nodes
  std::int32_t ring_joint;  // into PlanData::ring_joints; kNone: a flexible body or one of its markers
};
// Joints of loops that share joints: their reactions depend on each other.
struct LoopMesh {
  std::int32_t first, count;  // into PlanData::mesh_joints
};

// Loops that are eliminated where they close, see kernel/tree/loop_clusters.h and kernel/solver/loop_clusters.h. In
// order of elimination. A block has the rows of one loop and, in kEight lanes each, those of another.
struct LoopClosure {
  std::int32_t loop;                  // into PlanData::loops
  std::int32_t joint, non_tree;       // that closes it; its place in PlanData::non_tree_joints
  std::int32_t on_follower, on_base;  // slots at these bodies; kNone: the ground
  std::int32_t node;                  // into PlanData::cluster_nodes, where it closes; kNone: at the ground
  std::int32_t slot;                  // there, into PlanData::loop_slots
  std::int32_t block;                 // its own, into the blocks of Evaluation::cluster_matrix
  std::int32_t first_link, links;     // later loops that it is coupled with: into PlanData::loop_links
  std::int32_t first_pair;            // into PlanData::loop_pairs: blocks of pairs of these, i ≤ j, by rows
};
struct LoopLink {
  std::int32_t closure, block;
  std::int32_t slot;  // of that loop where this one closes; kNone: at the ground
};
// One loop at one node: its rows' wrenches there.
struct LoopSlot {
  std::int32_t closure;
  std::int32_t parent;   // the slot at the parent; kNone beyond a root
  std::int32_t begins;   // 1: the first to reach that slot, where nothing is yet; else 0
  std::int32_t numbers;  // into Evaluation::cluster_columns
};
struct ClusterNode {
  std::int32_t node, group;
  Place place;
  std::int32_t first_slot, closing, slots;  // of these, the first close here, the others pass on
  std::int32_t first_pair;                  // into PlanData::loop_pairs: of those that pass on
};
// Rows of a block of Λ, and numbers of it.
inline constexpr int kBlockNumbers = kRows * kEight;

// --- Bodies that bend or burn ----------------------------------------------------------------------------------------

// A flexible body, see kernel/dynamics/flexible.h.
struct PlanFlexible {
  std::int32_t body, modes;
  std::int32_t first_marker, markers;  // into PlanData::markers
  std::int32_t auxiliary;              // into State::auxiliary: its modal coordinates, then their rates
  std::int32_t numbers;                // into PlanData::modal: invariants, stiffness and damping
  std::int32_t work;                   // into Evaluation::modal
  std::int32_t inboard;                // marker that it is held by, into PlanData::markers; kNone for a root
  bool implicit;                       // some mode swings faster than the step resolves
  double mass;                         // kg
  Sym3 inertia;                        // undeformed, body axes, kg m²
};
struct PlanMarker {
  std::int32_t body, flexible;
  std::int32_t numbers;  // into PlanData::modal: Φ, then Ψ, three per mode
  Vec3 position;         // undeformed, from the body's origin, body axes, m
  bool bare;             // no joint hangs on it
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

// --- Elements --------------------------------------------------------------------------------------------------------

// A spring that is integrated implicitly, see kernel/elements/compliance.h.
struct PlanCompliant {
  std::int32_t spring;              // into PlanData::joint_springs
  NumberPlace pivot, acceleration;  // what it adds to its freedom's pivot, and that freedom's acceleration
  double side;                      // of the joint's child
};

// A displacement or rotation of a joint that an element, guard or sensor reads.
struct PlanCoordinate {
  std::int32_t joint, row;
  // of a rotation: its initial value, and the two axes of the rotation frame across its own, in each body's axes
  double initial = 0;
  Vec3 across_base[2]{}, across_follower[2]{};
};

struct PlanProfile {
  Profile::Kind kind;
  double value, initial, final, tau;
  std::int32_t first, count;  // kTable: into PlanData::knots; kHarmonic: into PlanData::harmonics
};

struct PlanLoad {
  std::int32_t body, element, profile, channel;
  bool world;                // it keeps its direction in the world, else in the body
  bool apart;                // each stage adds it by itself: in the world's axes, or sized by a law
  Vec3 point;                // of a force in the world, body axes
  Spatial wrench;            // of size 1, in its axes; in the body at the origin, in the world at the point
  double length;             // of the direction
  double consumption;        // kg per N s
  std::int32_t varying;      // into PlanData::varying: what burns it
  std::int32_t law = kNone;  // into PlanLaws::list: its size, instead of `profile`
};

struct PlanPointSpring {
  std::int32_t base, follower, element;
  bool push_only;
  Vec3 point_base, point_follower;
  double stiffness, damping, free_length;
};

struct PlanJointSpring {
  std::int32_t joint, axis, element;
  std::int32_t coordinate;  // into PlanData::coordinates
  double effort, stiffness, damping, rest;
  std::int32_t compliant;  // into PlanData::compliant, kNone if it is integrated explicitly
};

struct PlanPlaneTorsion {
  std::int32_t base, follower, element;
  Vec3 normal_base, axis_follower;
  double stiffness, damping;
};

// Shapes of a body, see Surface in unlatch/model.h.
struct PlanShapes {
  std::int32_t body;
  std::int32_t first, count;  // into PlanData::shape_parts
  geometry::GroupNumbers group;
  // Of the body that carries them, held by nothing: 1/kg, of a flexible body with the mobility of its modes there; 0
  // for the ground. About its origin, body axes, 1/(kg m²).
  double inverse_mass = 0;
  Mat3 inverse_inertia{};
};

// A contact, see kernel/elements/kinds/contact/contact.h.
struct PlanContact {
  std::int32_t base, follower, element;  // into PlanData::shapes; into State::elements
  std::int32_t first_pair, pairs;        // into PlanData::contact_pairs
  std::int32_t auxiliary;                // into State::auxiliary: ContactTotals
  bool hertzian;                         // n = 1.5, otherwise 1
  double stiffness, damping, friction, slip_speed;
};
struct ContactPair {
  std::int32_t contact, base_shape, follower_shape;  // into PlanData::contacts; into the groups' shapes
  bool closed;                                       // at the start
};

// A force on one side of a limit, see kernel/elements/kinds/one_sided/one_sided.h.
struct PlanOneSided {
  std::int32_t number, element;                          // its own place in PlanData::one_sided
  std::int32_t joint, axis, coordinate, base, follower;  // joint, coordinate: kNone between two points
  double sign, limit;
  bool guided;
  Vec3 point_base, point_follower, guide;
  OneSidedNumbers law;
  std::int32_t first, count;  // its table, into PlanData::travels and travel_forces
  std::int64_t engaged;       // at the start
  std::int32_t drum = kNone;  // into PlanData::drums and State::bearings
};

struct PlanFriction {
  std::int32_t joint, axis, element, coordinate;
  double coefficient, radius, speed;  // radius: 1 along an axis
};

struct PlanAeroTerm {
  AeroTerm::Of of;
  std::int32_t rate, law;
  double value;
};
struct PlanAerodynamics {
  std::int32_t body, element;
  std::int32_t first, count;  // into PlanData::aero_terms
  double area;
  Vec3 lengths, point;
};

struct PlanImpulse {
  std::int32_t body, channel;
  bool world;
  Vec3 point, linear, angular;
};

struct Knot {
  double time, value;
};

// --- Events and sensors ----------------------------------------------------------------------------------------------

// A quantity, see kernel/quantities. Its number among signals, bodies and so on is `subject`, as in the model.
struct PlanQuantity {
  Quantity::Kind kind;
  std::int32_t subject, other, part;
  std::int32_t coordinate = kNone;  // into PlanData::coordinates, of kinds that read one
  bool along = false;               // the component along `direction`
  bool guarded = false;             // of a condition: a bound serves that lies on the same side of `threshold`
  double threshold = 0;
  Vec3 direction{}, other_direction{}, point{};
};

// Guards in postfix order: a condition's parts stand before it. Compilation may rewrite `subject` and `axis`:
//
//   kind                             subject is an index into    axis
//   kReaction                        joints                      row
//   kDisplacement, kAngle, kSpeed    PlanData::coordinates       row
//   kMode                            joints                      number of the mode
//   kSignal                          signals
//   kClosed                          PlanData::contacts
//   kEngaged, kReach                 PlanData::one_sided
//   any other                        PlanData::quantities
struct PlanCondition {
  Condition::Kind kind;
  std::int32_t subject, axis, part_count;
  double threshold;
  bool below;
  std::int32_t first_mode;  // of a reaction: of its joint in PlanData::modes
  NumberPlace multiplier;   // likewise
};

struct PlanEvent {
  std::int32_t first_condition, condition_count, first_action, action_count;
  std::int32_t flat_parts;  // the first conditions that must all hold, where the guard is nothing else; otherwise 0
  double delay;
  bool repeat;
  std::int32_t engages;  // the one-sided force whose engagement it decides, or kNone
  std::int64_t engaged;  // what it decides
  bool by_time;          // the whole guard is "t ≥ T", which needs no search
  bool crossing;         // what holds at the start is no event
  bool timed;            // some quantity is the time since it acted: EventState::due keeps that, −1 before
};

struct PlanSensor {
  std::int32_t quantity;  // into PlanData::quantities
  std::int32_t first;     // into Workspace::sensors
  bool whole;             // all values of the quantity; otherwise the one that it chooses
};

// --- The whole -------------------------------------------------------------------------------------------------------

// Uniform and central gravity, see Gravity in unlatch/model.h.
struct GravityField {
  Vec3 uniform{};
  double mu = 0;
  Vec3 centre{};
};

// Part of a step: times nearer than this are one instant.
inline constexpr double kSameInstant = 1e-9;

// Numbers of a plan.
struct PlanNumbers {
  PlanOptions options;
  InstructionSet instruction_set = InstructionSet::kScalar;  // chosen for this processor
  std::uint64_t hash = 0;  // of the model and its options: two plans with one hash step alike
  double get_time(std::int64_t tick) const { return static_cast<double>(tick) * options.dt; }  // s
  double get_slack() const { return kSameInstant * options.dt; }  // s: times nearer than this are one instant

  // loops
  std::int32_t loop_rows = 0, loop_columns = 0;  // that the loops' joints hold at most; the same, padded for packs
  std::int32_t loop_load_rows = 0;               // of Evaluation::loop_loads, before its scratch
  std::int32_t loop_modal_rows = 0;              // of these, the first, of modal coordinates
  std::int32_t ring_rows = 0;                    // that PlanLists::ring_joints hold at most
  std::int32_t first_at_ground = 0;              // of PlanLists::closures: it and the later ones close there
  std::int32_t cluster_blocks = 0;               // of Evaluation::cluster_matrix
  std::int32_t cluster_numbers = 0;              // of Evaluation::cluster_columns

  // blocks, bodies that bend or burn
  std::int32_t block_numbers = 0;  // size of Evaluation::blocks
  std::int32_t modal_work = 0;     // size of Evaluation::modal
  bool rigid = true;               // no body bends or changes its mass: the lists of these are empty
  bool plain = true;  // likewise, and there is no planet: init_forces() has all that acts on bodies by themselves

  // elements
  GravityField gravity;
  PlanEnvironment environment;
  std::int32_t driven_coordinates = 0;  // of PlanLists::coordinates, the first, that every stage needs for springs
  std::int32_t rotation_count = 0;      // rotations among them all
  bool commanded_loads = false;         // a command decides the size of some load, or some law
  std::int32_t contact_substeps = 1;    // kAutomaticSubsteps, or a number
  bool pair_forces = false;             // there is an element other than loads

  PlanLawNumbers law_numbers;

  // events and sensors
  bool commanded_events = false;    // a command decides some guard, itself or through the reactions
  std::int32_t quantity_count = 0;  // of PlanLists::quantities, the model's
  std::int32_t sensor_count = 0;    // values, all sensors' components counted
  std::int32_t signal_count = 0;
  std::int32_t channel_count = 0;
  std::int32_t guard_depth = 0;  // values that evaluating the deepest guard keeps at once
};

// Lists of a plan. A new list goes into for_each_list() of plan_lists.h as well.
template <template <class> class List>
struct PlanLists {
  // tree
  List<TreeNode> nodes;
  List<PlanBody> bodies;
  List<PlanJoint> joints;
  List<RowSet> modes;
  List<PlanNonTreeJoint> non_tree_joints;

  // loops
  List<std::int32_t> loops;   // joints that close a loop over the tree
  List<LoopNode> loop_nodes;  // children before parents
  List<LoopEnd> loop_ends;
  List<LoopPath> loop_paths;  // per loop
  List<PathNode> path_nodes;
  List<std::int32_t> ring_joints;  // joints of the tree that lie in loops
  List<LoopMesh> meshes;
  List<std::int32_t> mesh_joints;  // of each mesh, in the order of the model

  // loops that are eliminated where they close; empty if all are by one dense matrix
  List<LoopClosure> closures;
  List<LoopLink> loop_links;
  List<LoopSlot> loop_slots;
  List<std::int32_t> loop_pairs;
  List<ClusterNode> cluster_nodes;    // parents before children
  List<std::int32_t> group_clusters;  // per group: its first cluster node; and the end

  // blocks, see blocks.h
  List<BodyEight> eights;
  List<Group> groups;                // parents before children
  List<std::int32_t> inner_groups;   // whose SubtreeBlocks no child begins, see Group::begins
  List<std::int32_t> lane_nodes;     // per lane: its node, or kNone
  List<Place> lane_parents;          // per lane: where its parent is
  List<Place> places;                // per body
  List<NumberColumn> multipliers;    // per joint: the six of them
  List<NumberColumn> accelerations;  // per body: the six of it
  List<double> body_constants;       // BodyConstants of each block of eight
  List<double> joint_constants;      // JointConstants, and RotationConstants if needed, of each group
  List<double> solver_constants;     // SolverConstants of each group

  // bodies that bend or burn
  List<PlanVarying> varying;
  List<MassKnot> mass_knots;
  List<PlanFlexible> flexible;
  List<PlanMarker> markers;  // those of one flexible body together
  List<double> modal;
  List<double> initial_auxiliary;  // auxiliary states: burnt by each of `varying`, modal ones, contacts

  // elements
  List<PlanCoordinate> coordinates;  // that somebody reads, or their rates
  List<PlanLoad> loads;
  List<std::int32_t> external_loads;  // of these, those that stand apart or burn something
  List<PlanPointSpring> point_springs;
  List<PlanJointSpring> joint_springs;
  List<PlanCompliant> compliant;
  List<RowSet> compliant_axes;  // per joint: axes with implicit springs
  List<PlanPlaneTorsion> plane_torsions;
  List<PlanShapes> shapes;
  List<geometry::ShapeNumbers> shape_parts;     // those of one of `shapes` together
  List<Vec3> hull_points;                       // of hulls
  List<geometry::ProfilePoint> profile_points;  // of hollow shapes
  List<PlanContact> contacts;
  List<ContactPair> contact_pairs;  // those of one contact together
  List<PlanOneSided> one_sided;
  List<CordDrum> drums;  // of cords, in the model's order
  List<double> travels, travel_forces;
  List<PlanFriction> frictions;
  List<PlanAerodynamics> aerodynamics;
  List<PlanAeroTerm> aero_terms;
  List<AirLayer> air_layers;  // of the standard atmosphere
  List<AirKnot> air_knots;    // of the atmosphere
  List<WindKnot> wind_knots;  // of the wind
  List<PlanProfile> profiles;
  List<Knot> knots;
  List<Profile::Harmonic> harmonics;
  PlanLawLists<List> laws;
  List<double> element_scales;  // initial switch scale per element: 0 or 1

  // events and sensors
  List<PlanCondition> conditions;
  List<Action> actions;
  List<PlanImpulse> impulses;
  List<PlanEvent> events;
  List<std::int32_t> repeating_events;
  List<std::int32_t> timed_events;  // that are due at a known time: by their guard, or after a delay
  List<PlanQuantity> quantities;    // the model's, then those of conditions, then those of sensors
  List<PlanSensor> sensors;
  List<double> initial_commands;  // of the channels

  RowSet get_rows(int joint, std::int64_t mode) const {
    return modes[static_cast<std::size_t>(joints[static_cast<std::size_t>(joint)].first_mode + mode)];
  }
};

// A plan to step with. Its lists lie in an image (plan_image.h), which outlives it.
struct PlanData : PlanNumbers, PlanLists<FixedList> {
  std::span<const std::byte> image;
};

// A plan while it is compiled.
struct PlanDraft : PlanNumbers, PlanLists<GrowingList> {};

inline const PlanData& get_data(const Plan& plan) noexcept { return *plan.data_; }

}  // namespace unlatch
