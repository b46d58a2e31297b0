#include <algorithm>
#include <map>

#include "kernel/compile/bodies.h"
#include "kernel/compile/constants.h"
#include "kernel/compile/contacts.h"
#include "kernel/compile/elements.h"
#include "kernel/compile/events.h"
#include "kernel/compile/layout.h"
#include "kernel/compile/one_sided.h"
#include "kernel/compile/quantities.h"
#include "kernel/compile/stiff_springs.h"
#include "kernel/joints/coordinates.h"
#include "kernel/model/from_eigen.h"
#include "kernel/model/model_hash.h"
#include "kernel/simd/instruction_set.h"
#include "kernel/tree/groups.h"
#include "kernel/tree/loop_clusters.h"
#include "kernel/tree/loop_nodes.h"
#include "kernel/tree/loop_paths.h"
#include "kernel/tree/topology.h"
#include "unlatch/plan.h"

namespace unlatch {
namespace {

// The coordinates that somebody reads; the others are not computed.
class Coordinates {
 public:
  explicit Coordinates(PlanData& plan) : plan_(plan) {}

  // Its place in PlanData::coordinates.
  std::int32_t find(int joint, int axis) {
    const auto next = static_cast<std::int32_t>(plan_.coordinates.size());
    const auto [found, is_new] = known_.emplace(std::pair(joint, axis), next);
    if (is_new) {
      plan_.coordinates.push_back({.joint = joint, .row = axis});
      if (axis >= kRotX) ++plan_.rotation_count;
    }
    return found->second;
  }

 private:
  PlanData& plan_;
  std::map<std::pair<int, int>, std::int32_t> known_;
};

void link_conditions(PlanData& plan, Coordinates& coordinates) {
  for (PlanCondition& c : plan.conditions)
    if (c.kind == Condition::Kind::kAngle || c.kind == Condition::Kind::kDisplacement ||
        c.kind == Condition::Kind::kSpeed)
      c.subject = coordinates.find(c.subject, c.axis);
}

// What quantities read of others: coordinates, the times of events. Those of conditions that guards read by themselves
// stand before them.
void link_quantities(PlanData& plan, Coordinates& coordinates) {
  for (PlanQuantity& quantity : plan.quantities) {
    const QuantityTraits& traits = get_traits(quantity.kind);
    if ((traits.reads & kReadsCoordinate) != 0) quantity.coordinate = coordinates.find(quantity.subject, quantity.part);
    if (traits.of == SubjectOf::kEvent) plan.events[at(quantity.subject)].timed = true;
  }
}

// Multipliers that guards read.
void place_multipliers(PlanData& plan) {
  for (PlanCondition& c : plan.conditions) {
    if (c.kind != Condition::Kind::kReaction) continue;
    const NumberColumn multipliers = plan.multipliers[at(c.subject)];
    c.first_mode = plan.joints[at(c.subject)].first_mode;
    c.multiplier = {multipliers.first + c.axis * multipliers.stride};
  }
}

PlanJoint compile_joint(const Model& model, const Joint& joint, int first_mode) {
  const RotationFrame frame = get_rotation_frame(model, joint);
  return {to_quat(Eigen::Quaterniond(frame.base)),
          to_quat(Eigen::Quaterniond(frame.follower)),
          joint.base,
          joint.follower,
          first_mode,
          static_cast<std::int32_t>(joint.mode),
          joint.universal};
}

// Axes by which rotations are measured, and their initial angles: they are counted on from step to step.
void init_angles(const Model& model, PlanData& plan) {
  for (PlanCoordinate& c : plan.coordinates) {
    if (c.row < kRotX) continue;
    const Joint& joint = model.joints[at(c.joint)];
    const RotationFrame frame = get_rotation_frame(model, joint);
    const Mat3 base = to_mat(frame.base), follower = to_mat(frame.follower);
    const int own = c.row - kRotX;
    for (int k = 0; k < 2; ++k) {
      c.across_base[k] = column(base, (own + 1 + k) % 3);
      c.across_follower[k] = column(follower, (own + 1 + k) % 3);
    }
    c.initial = calc_twist(to_mat(get_attitude(model, joint.base)) * base,
                           to_mat(get_attitude(model, joint.follower)) * follower, own);
  }
}

// Loads with one law share its profile: four boosters have one thrust curve, computed once.
class Profiles {
 public:
  explicit Profiles(PlanData& plan) : plan_(plan) {}

  std::int32_t compile(const Profile& profile) {
    const auto [found, is_new] = known_.emplace(list_numbers(profile), static_cast<std::int32_t>(known_.size()));
    if (is_new) append(profile);
    return found->second;
  }

 private:
  static std::vector<double> list_numbers(const Profile& p) {
    std::vector<double> all{static_cast<double>(p.kind), p.value, p.initial, p.final, p.tau};
    all.insert(all.end(), p.times.begin(), p.times.end());
    all.insert(all.end(), p.values.begin(), p.values.end());
    for (const Profile::Harmonic& h : p.harmonics) all.insert(all.end(), {h.amplitude, h.frequency, h.phase});
    return all;
  }

  void append(const Profile& profile) {
    PlanProfile out{profile.kind, profile.value, profile.initial, profile.final, profile.tau, 0, 0};
    if (profile.kind == Profile::Kind::kTable) {
      out.first = static_cast<std::int32_t>(plan_.knots.size());
      out.count = static_cast<std::int32_t>(profile.times.size());
      for (std::size_t i = 0; i < profile.times.size(); ++i)
        plan_.knots.push_back({profile.times[i], profile.values[i]});
    } else if (profile.kind == Profile::Kind::kHarmonic) {
      out.first = static_cast<std::int32_t>(plan_.harmonics.size());
      out.count = static_cast<std::int32_t>(profile.harmonics.size());
      plan_.harmonics.insert(plan_.harmonics.end(), profile.harmonics.begin(), profile.harmonics.end());
    }
    plan_.profiles.push_back(out);
  }

  PlanData& plan_;
  std::map<std::vector<double>, std::int32_t> known_;
};

// Per joint spring, its place in PlanData::compliant; kNone if it is integrated explicitly.
std::vector<std::int32_t> list_compliant(const Model& model, const PlanData& plan) {
  std::vector<std::int32_t> places(model.joint_springs.size(), kNone);
  for (std::size_t i = 0; i < plan.compliant.size(); ++i)
    places[at(plan.compliant[i].spring)] = static_cast<std::int32_t>(i);
  return places;
}

// Per joint, the axes of the springs in `chosen`.
std::vector<RowSet> list_axes(const Model& model, const std::vector<bool>& chosen) {
  std::vector<RowSet> axes(model.joints.size(), 0);
  for (std::size_t i = 0; i < model.joint_springs.size(); ++i)
    if (chosen[i]) {
      RowSet& of_joint = axes[at(model.joint_springs[i].joint)];
      of_joint = static_cast<RowSet>(of_joint | row_bit(model.joint_springs[i].axis));
    }
  return axes;
}

// Springs that are integrated implicitly: those that the user or the step size wants so, if their joint is an edge of
// the tree. Returns what the tree refuses to those that the user wants.
std::vector<ModelError> compile_compliance(const Model& model, const std::vector<bool>& stiff, PlanData& plan) {
  std::vector<ModelError> errors;
  std::vector<bool> edge(model.joints.size(), false);
  for (const TreeNode& node : plan.nodes)
    if (node.joint != kNone) edge[at(node.joint)] = true;
  plan.compliant_axes.assign(model.joints.size(), 0);
  for (std::size_t i = 0; i < model.joint_springs.size(); ++i) {
    const JointSpring& spring = model.joint_springs[i];
    const std::vector<JointMode>& modes = model.joints[at(spring.joint)].modes;
    const auto frees = [&](const JointMode& mode) { return !has_row(mode.rows, spring.axis); };
    if (!stiff[i] || std::none_of(modes.begin(), modes.end(), frees)) continue;
    if (edge[at(spring.joint)]) {
      plan.compliant.push_back({static_cast<std::int32_t>(i), {}, {}, 0});
      RowSet& axes = plan.compliant_axes[at(spring.joint)];
      axes = static_cast<RowSet>(axes | row_bit(spring.axis));
    } else if (spring.implicit.value_or(false)) {
      errors.push_back({"element '" + spring.name + "'",
                        "its joint closes a loop, where no spring can be integrated implicitly",
                        "leave `implicit` out: one joint of every loop goes without", "implicit"});
    }
  }
  return errors;
}

// Elements before the contacts, in the order of kernel/model/elements.h.
void compile_elements(const Model& model, PlanData& plan, Coordinates& coordinates) {
  Profiles profiles(plan);
  for (const Load& l : model.loads) {
    const bool world = l.frame == Load::Frame::kWorld;
    const Vec3 none{0, 0, 0}, point = l.kind == Load::Kind::kTorque ? none : to_vec(l.point),
                              size = to_vec(l.direction);
    plan.loads.push_back(
        {l.body, add_element(plan, l.on), profiles.compile(l.profile), l.channel, world, point,
         l.kind == Load::Kind::kTorque ? Spatial{none, size} : Spatial{size, world ? none : cross(point, size)},
         l.direction.norm(), l.consumption, plan.bodies[at(l.tank == kNone ? l.body : l.tank)].varying});
    if (world || l.consumption != 0) plan.external_loads.push_back(static_cast<std::int32_t>(plan.loads.size()) - 1);
    if (l.channel != kNone) plan.commanded_loads = true;
  }
  for (const PointSpring& s : model.point_springs)
    plan.point_springs.push_back({s.base, s.follower, add_element(plan, s.on), s.push_only, to_vec(s.point_base),
                                  to_vec(s.point_follower), s.stiffness, s.damping, s.free_length});
  const std::vector<std::int32_t> compliant = list_compliant(model, plan);
  const JointSpring* first = model.joint_springs.data();
  for (const JointSpring& s : model.joint_springs)
    plan.joint_springs.push_back({s.joint, s.axis, add_element(plan, s.on), coordinates.find(s.joint, s.axis), s.effort,
                                  s.stiffness, s.damping, s.rest, compliant[static_cast<std::size_t>(&s - first)]});
  // Every stage needs the coordinates up to here: those that forces read. Conditions and sensors add theirs later.
  for (const OneSided& f : model.one_sided)
    if (f.joint != kNone) coordinates.find(f.joint, f.axis);
  for (const JointFriction& f : model.frictions) coordinates.find(f.joint, f.axis);
  plan.driven_coordinates = static_cast<std::int32_t>(plan.coordinates.size());
  for (const PlaneTorsion& s : model.plane_torsions)
    plan.plane_torsions.push_back({s.base, s.follower, add_element(plan, s.on), to_vec(s.normal_base),
                                   to_vec(s.axis_follower), s.stiffness, s.damping});
}

// After the contacts, in the numbering of elements too. compile_elements() has made their coordinates.
void compile_one_sided_and_frictions(const Model& model, PlanData& plan, Coordinates& coordinates) {
  for (const OneSided& f : model.one_sided)
    compile_one_sided(model, f, add_element(plan, f.on), f.joint == kNone ? kNone : coordinates.find(f.joint, f.axis),
                      plan);
  for (const JointFriction& f : model.frictions)
    plan.frictions.push_back({f.joint, f.axis, add_element(plan, f.on), coordinates.find(f.joint, f.axis),
                              f.coefficient, f.axis >= kRotX ? f.radius : 1.0, f.speed});
}

// Elements that push two bodies apart: without one, add_forces() calls none of them. A new kind is added here and in
// add_pair_forces() of kernel/dynamics/forces.cc, behind the others, so that no sum changes.
bool has_pair_forces(const PlanData& plan) {
  return !plan.point_springs.empty() || !plan.joint_springs.empty() || !plan.plane_torsions.empty() ||
         !plan.contacts.empty() || !plan.one_sided.empty() || !plan.frictions.empty();
}

void compile_impulses(const Model& model, PlanData& plan) {
  for (const Impulse& i : model.impulses)
    plan.impulses.push_back(
        {i.body, i.channel, i.frame == Load::Frame::kWorld, to_vec(i.point), to_vec(i.linear), to_vec(i.angular)});
}

void compile_sensors(const Model& model, PlanData& plan) {
  for (const Sensor& sensor : model.sensors) {
    const Quantity quantity = get_quantity(model, sensor);
    plan.sensors.push_back({add_quantity(quantity, plan), plan.sensor_count, quantity.part == Quantity::kAll});
    plan.sensor_count += sensor_width(sensor.kind);
  }
}

void check_options(const Model& model, const PlanOptions& options, std::vector<ModelError>& errors) {
  if (!(options.dt > 0) || !std::isfinite(options.dt))
    errors.push_back(
        {"step", "dt is " + std::to_string(options.dt) + " s", "give a positive step, for example 0.001 s"});
  if (options.max_splits < 1)
    errors.push_back(
        {"step", "max_splits is " + std::to_string(options.max_splits), "allow at least one event per step"});
  if (!is_supported(options.instruction_set))
    errors.push_back({"step", std::string("this build or this processor has no ") + get_name(options.instruction_set),
                      "leave the instruction set to be chosen"});
  if (options.root < kNone || options.root >= static_cast<int>(model.bodies.size()))
    errors.push_back({"step", "root is not a body of the model", "name one of its bodies, or leave it out"});
}

// First phase: the tree. Errors: what it refuses.
std::vector<ModelError> compile_tree(const Model& model, PlanData& plan) {
  const std::vector<bool> stiff = find_stiff_springs(model, plan.options.dt);
  Topology topology = compile_topology(model, list_axes(model, stiff), plan.options.root);
  plan.nodes = std::move(topology.nodes);
  plan.loops = std::move(topology.loops);
  return compile_compliance(model, stiff, plan);
}

// Second phase: bodies, joints, elements, events and sensors, by number. The order matters where a line says so.
void compile_parts(const Model& model, PlanData& plan) {
  compile_bodies(model, plan);
  compile_quantities(model, plan);  // before conditions and sensors add theirs
  compile_events(model, plan);
  compile_impulses(model, plan);
  for (const Joint& joint : model.joints) {
    plan.joints.push_back(compile_joint(model, joint, static_cast<int>(plan.modes.size())));
    for (const JointMode& mode : joint.modes) plan.modes.push_back(mode.rows);
  }
  Coordinates coordinates(plan);
  compile_elements(model, plan, coordinates);  // before conditions and sensors: driven coordinates come first
  compile_contacts(model, plan);               // after the bodies: its totals stand behind their auxiliary states
  compile_one_sided_and_frictions(model, plan, coordinates);
  plan.pair_forces = has_pair_forces(plan);
  link_conditions(plan, coordinates);  // after compile_events()
  plan.commanded_events = plan.commanded_loads || has_commanded_guards(plan);
  compile_sensors(model, plan);
  link_quantities(plan, coordinates);
  init_angles(model, plan);  // of all coordinates: after the last of them was found
  plan.gravity = {to_vec(model.gravity.uniform), model.gravity.mu, to_vec(model.gravity.centre)};
  plan.signal_count = static_cast<std::int32_t>(model.signals.size());
  plan.channel_count = static_cast<std::int32_t>(model.channels.size());
}

// Third phase: places in memory, and constants there; needs all parts.
void compile_memory(const Model& model, PlanData& plan) {
  // Numbers the nodes anew: before all that keeps a node or a place.
  lay_out_blocks(model, group_nodes(model, plan.nodes, plan.compliant_axes), plan);
  fill_constants(model, plan);
  compile_loops(model, plan);
  compile_clusters(plan);
  compile_loop_paths(model, plan);  // after compile_loops(): it leads through loop nodes
  place_multipliers(plan);
}

PlanResult compile_placed(const Model& model, const PlanOptions& options) {
  PlanResult result;
  result.errors = validate(model);
  check_options(model, options, result.errors);
  if (!result.errors.empty()) return result;

  PlanData plan;
  plan.options = options;
  plan.instruction_set = resolve(options.instruction_set);
  result.errors = compile_tree(model, plan);
  if (!result.errors.empty()) return result;
  compile_parts(model, plan);
  compile_memory(model, plan);
  plan.hash = calc_model_hash(model, options);
  result.plan.emplace(std::make_shared<const PlanData>(std::move(plan)));
  return result;
}

}  // namespace

PlanResult compile_plan(const Model& model, const PlanOptions& options) {
  if (!model.one_sided.empty()) return compile_placed(place_markers(complete_events(model)), options);
  return has_markers(model) ? compile_placed(place_markers(model), options) : compile_placed(model, options);
}

}  // namespace unlatch
