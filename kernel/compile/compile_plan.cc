#include <algorithm>

#include "kernel/compile/bodies.h"
#include "kernel/compile/constants.h"
#include "kernel/compile/events.h"
#include "kernel/compile/layout.h"
#include "kernel/compile/model_hash.h"
#include "kernel/compile/quantities.h"
#include "kernel/compile/stiff_springs.h"
#include "kernel/compile/surfaces.h"
#include "kernel/elements/kinds/kinds.h"
#include "kernel/environment/environment_model.h"
#include "kernel/laws/law_model.h"
#include "kernel/math/number_text.h"
#include "kernel/model/from_eigen.h"
#include "kernel/plan/build_image.h"
#include "kernel/simd/instruction_set.h"
#include "kernel/tree/groups.h"
#include "kernel/tree/loop_clusters.h"
#include "kernel/tree/loop_nodes.h"
#include "kernel/tree/loop_paths.h"
#include "kernel/tree/topology.h"
#include "unlatch/motion.h"
#include "unlatch/plan.h"

namespace unlatch {
namespace {

// Places of the multipliers that guards read.
void place_multipliers(const LaidOutDraft& draft) {
  PlanDraft& plan = draft.plan;
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

// Springs that are integrated implicitly: those in `stiff` whose joint is an edge of the tree. Returns an error for
// each other spring that the user demands to be.
std::vector<ModelError> compile_compliance(const Model& model, const std::vector<bool>& stiff, PlanDraft& plan) {
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

// What reads quantities: guards and sensors.
struct DraftWithReaders {
  PlanDraft& plan;
};

DraftWithReaders compile_readers(const Model& model, const DraftWithQuantities& draft) {
  PlanDraft& plan = draft.plan;
  compile_events(model, draft);
  for (const Sensor& sensor : model.sensors) {
    const Quantity quantity = get_quantity(model, sensor);
    plan.sensors.push_back({add_quantity(quantity, plan), plan.sensor_count, quantity.part == Quantity::kAll});
    plan.sensor_count += sensor_width(sensor.kind);
  }
  return {plan};
}

// All elements, numbered in the order of kinds.h. The compiler that is returned knows the coordinates that forces read.
ElementCompiler compile_elements(const Model& model, const DraftWithBodies& draft) {
  PlanDraft& plan = draft.plan;
  ElementCompiler compiler(model, plan);
  for_each_kind([&]<class Kind>(Kind) {
    for (const auto& item : Kind::of(model)) {
      plan.element_scales.push_back(item.on ? 1 : 0);
      Kind::of_plan(plan).push_back(Kind::compile(item, compiler));
    }
    // add_forces() calls the kinds other than loads only if the model has such an element.
    if constexpr (!std::is_same_v<Kind, LoadKind>) plan.pair_forces = plan.pair_forces || !Kind::of_plan(plan).empty();
  });
  compile_laws(model, compiler);
  // Every stage needs the coordinates up to here: those that forces read, and laws that forces read.
  plan.driven_coordinates = static_cast<std::int32_t>(plan.coordinates.size());
  return compiler;
}

// Axes by which rotations are measured, and their initial angles, from which turns are counted.
void init_angles(const Model& model, PlanDraft& plan) {
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

// Behind the coordinates that forces read, those of guards and sensors; what guards and sensors are linked to; where
// the angles of all coordinates begin.
void link_readers(const Model& model, const DraftWithReaders& draft, ElementCompiler compiler) {
  PlanDraft& plan = draft.plan;
  for (PlanCondition& c : plan.conditions)
    if (c.kind == Condition::Kind::kAngle || c.kind == Condition::Kind::kDisplacement ||
        c.kind == Condition::Kind::kSpeed)
      c.subject = compiler.find_coordinate(c.subject, c.axis);
  for (PlanQuantity& quantity : plan.quantities) {
    const QuantityTraits& traits = get_traits(quantity.kind);
    if ((traits.reads & kReadsCoordinate) != 0)
      quantity.coordinate = compiler.find_coordinate(quantity.subject, quantity.part);
    if (traits.of == SubjectOf::kEvent) plan.events[at(quantity.subject)].timed = true;
  }
  plan.commanded_events = plan.commanded_loads || has_commanded_guards(plan);
  init_angles(model, plan);
}

void compile_impulses(const Model& model, PlanDraft& plan) {
  for (const Impulse& i : model.impulses)
    plan.impulses.push_back(
        {i.body, i.channel, i.frame == Load::Frame::kWorld, to_vec(i.point), to_vec(i.linear), to_vec(i.angular)});
}

void check_options(const Model& model, const PlanOptions& options, std::vector<ModelError>& errors) {
  if (!(options.dt > 0) || !std::isfinite(options.dt))
    errors.push_back({"step", "dt is " + show(options.dt) + " s", "give a positive step, for example 0.001 s"});
  if (options.max_splits < 1)
    errors.push_back(
        {"step", "max_splits is " + std::to_string(options.max_splits), "allow at least one event per step"});
  if (!is_supported(options.instruction_set))
    errors.push_back({"step", std::string("this build or this processor has no ") + get_name(options.instruction_set),
                      "leave the instruction set to be chosen"});
  if (options.root < kNone || options.root >= static_cast<int>(model.bodies.size()))
    errors.push_back({"step", "root is not a body of the model", "name one of its bodies, or leave it out"});
}

// First phase: the tree. Returns its errors.
std::vector<ModelError> compile_tree(const Model& model, PlanDraft& plan) {
  const std::vector<bool> stiff = find_stiff_springs(model, plan.options.dt);
  Topology topology = compile_topology(model, list_axes(model, stiff), plan.options.root);
  plan.nodes = std::move(topology.nodes);
  plan.loops = std::move(topology.loops);
  return compile_compliance(model, stiff, plan);
}

bool has_masses(const PlanDraft& plan, bool by_burnt) {
  return std::any_of(plan.varying.begin(), plan.varying.end(),
                     [&](const PlanVarying& mass) { return mass.by_burnt == by_burnt; });
}
// Corners whose time is known: points of tables over time, knots of masses, ends of ramps.
bool has_time_corners(const Model& model, const PlanDraft& plan) {
  const auto ramps = [](const Event& event) {
    return std::any_of(event.then.begin(), event.then.end(),
                       [](const Action& action) { return action.kind == Action::Kind::kRamp; });
  };
  return !plan.knots.empty() || has_masses(plan, false) || std::any_of(model.events.begin(), model.events.end(), ramps);
}

// Second phase: bodies, joints, elements, events and sensors, by number. What a part needs of another is an argument.
void compile_parts(const Model& model, PlanDraft& plan) {
  const DraftWithBodies bodies = compile_bodies(model, plan.nodes, plan);
  for (const Joint& joint : model.joints) {
    plan.joints.push_back(compile_joint(model, joint, static_cast<int>(plan.modes.size())));
    for (const JointMode& mode : joint.modes) plan.modes.push_back(mode.rows);
  }
  compile_surfaces(model, plan);
  compile_impulses(model, plan);
  const DraftWithReaders readers = compile_readers(model, compile_quantities(model, plan));
  link_readers(model, readers, compile_elements(model, bodies));
  plan.gravity = {to_vec(model.gravity.uniform), model.gravity.mu, to_vec(model.gravity.centre)};
  CompiledEnvironment environment = compile_environment(model.environment);
  plan.environment = environment.numbers;
  plan.air_layers = std::move(environment.layers);
  plan.air_knots = std::move(environment.air);
  plan.wind_knots = std::move(environment.wind);
  if (!plan.aerodynamics.empty()) plan.air_corners = std::move(environment.corners);
  plan.plain = plan.rigid && !plan.environment.exists;
  plan.solved_once = plan.laws.list.empty() && plan.frictions.empty() && plan.rigid_pairs == 0;
  plan.time_corners = has_time_corners(model, plan);
  plan.place_corners = !plan.laws.corners.empty() || !plan.air_corners.empty() || !plan.travels.empty();
  plan.sought_corners = plan.place_corners || has_masses(plan, true) || !plan.contacts.empty();
  plan.contact_substeps = model.contact_substeps;
  plan.signal_count = static_cast<std::int32_t>(model.signals.size());
  plan.channel_count = static_cast<std::int32_t>(model.channels.size());
  for (const Channel& channel : model.channels) plan.initial_commands.push_back(channel.initial);
}

// Third phase: places in memory, and what lies there.
void compile_memory(const Model& model, PlanDraft& plan) {
  const LaidOutDraft draft = lay_out_blocks(model, group_nodes(model, plan.nodes, plan.compliant_axes), plan);
  fill_constants(model, draft);
  compile_loop_paths(model, compile_loop_nodes(model, draft), plan);
  compile_clusters(draft);
  place_multipliers(draft);
}

PlanResult compile_placed(const Model& model, const PlanOptions& options) {
  PlanResult result;
  result.errors = validate(model);
  check_options(model, options, result.errors);
  if (!result.errors.empty()) return result;

  PlanDraft plan;
  plan.options = options;
  plan.instruction_set = resolve(options.instruction_set);
  result.errors = compile_tree(model, plan);
  if (!result.errors.empty()) return result;
  compile_parts(model, plan);
  compile_memory(model, plan);
  plan.hash = calc_model_hash(model, options);
  result.plan = build_plan(plan);
  return result;
}

}  // namespace

PlanResult compile_plan(const Model& model, const PlanOptions& options) {
  if (!model.one_sided.empty()) return compile_placed(place_markers(complete_events(model)), options);
  return has_markers(model) ? compile_placed(place_markers(model), options) : compile_placed(model, options);
}

}  // namespace unlatch
