#include "kernel/plan.h"

#include <algorithm>

#include "kernel/kinematics.h"
#include "kernel/lane_kernels.h"
#include "kernel/model_hash.h"
#include "kernel/topology.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 to_vec(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
Mat3 to_mat(const Eigen::Matrix3d& m) { return {to_vec(m.col(0)), to_vec(m.col(1)), to_vec(m.col(2))}; }
Sym3 to_sym(const Eigen::Matrix3d& m) { return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)}; }
Quat to_quat(const Eigen::Quaterniond& q) { return normalized({q.w(), q.x(), q.y(), q.z()}); }
Quat to_quat(const Eigen::Matrix3d& m) { return to_quat(Eigen::Quaterniond(m)); }

Eigen::Matrix3d get_attitude(const Model& model, int body) {
  return body == kGround ? Eigen::Matrix3d::Identity() : model.bodies[at(body)].q_WB.normalized().toRotationMatrix();
}

PlanBody compile_body(const Body& body) {
  return {
      body.mass, to_sym(body.inertia), {to_vec(body.p_WB), to_quat(body.q_WB), to_vec(body.v_WB), to_vec(body.w_WB_B)}};
}

// Which coordinates of a joint somebody reads; the others are not computed. Bit r: Row r.
struct ReadCoordinates {
  RowSet by_springs = 0, by_any = 0;
};

std::vector<ReadCoordinates> find_read_coordinates(const Model& model, const std::vector<PlanCondition>& conditions) {
  std::vector<ReadCoordinates> read(model.joints.size());
  const auto mark = [&](int joint, int axis) {
    read[at(joint)].by_any = static_cast<RowSet>(read[at(joint)].by_any | row_bit(axis));
  };
  for (const JointSpring& spring : model.joint_springs) {
    mark(spring.joint, spring.axis);
    RowSet& driven = read[at(spring.joint)].by_springs;
    driven = static_cast<RowSet>(driven | row_bit(spring.axis));
  }
  for (const PlanCondition& c : conditions)
    if (c.kind == Condition::Kind::kAngle || c.kind == Condition::Kind::kDisplacement ||
        c.kind == Condition::Kind::kSpeed)
      mark(c.subject, c.axis);
  for (const Sensor& sensor : model.sensors)
    if (sensor.kind == Sensor::Kind::kAngle || sensor.kind == Sensor::Kind::kDisplacement ||
        sensor.kind == Sensor::Kind::kSpeed)
      mark(sensor.subject, sensor.axis);
  return read;
}

PlanJoint compile_joint(const Model& model, const Joint& joint, const ReadCoordinates& read, int first_mode) {
  const Eigen::Matrix3d base = get_attitude(model, joint.base), follower = get_attitude(model, joint.follower);
  const Eigen::Matrix3d rotation_base = joint.rotation_axes.value_or(joint.axes);
  const Eigen::Matrix3d rotation_follower = joint.follower_axes.value_or(follower.transpose() * base * rotation_base);
  PlanJoint out{joint.base,
                joint.follower,
                to_vec(joint.point_base),
                to_vec(joint.point_follower),
                to_mat(joint.axes),
                to_mat(rotation_base),
                to_mat(rotation_follower),
                to_quat(rotation_base),
                to_quat(rotation_follower),
                !joint.rotation_axes.has_value(),
                joint.universal,
                read.by_any,
                read.by_springs,
                first_mode,
                {}};
  out.initial = {joint.mode, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}};
  for (int k = 0; k < 3; ++k)
    if (has_row(read.by_any, kRotX + k))
      out.initial.angle[k] = calc_twist(to_mat(base * rotation_base), to_mat(follower * rotation_follower), k);
  return out;
}

bool is_same(const Profile& a, const Profile& b) {
  const auto equal = [](const Profile::Harmonic& x, const Profile::Harmonic& y) {
    return x.amplitude == y.amplitude && x.frequency == y.frequency && x.phase == y.phase;
  };
  return a.kind == b.kind && a.value == b.value && a.initial == b.initial && a.final == b.final && a.tau == b.tau &&
         a.times == b.times && a.values == b.values &&
         std::equal(a.harmonics.begin(), a.harmonics.end(), b.harmonics.begin(), b.harmonics.end(), equal);
}

// Loads that follow each other with one law share its profile: four boosters have one thrust curve.
std::int32_t compile_profile(const Profile& profile, const Profile* previous, Plan& plan) {
  if (previous != nullptr && is_same(profile, *previous)) return static_cast<std::int32_t>(plan.profiles.size()) - 1;
  PlanProfile out{profile.kind, profile.value, profile.initial, profile.final, profile.tau, 0, 0};
  if (profile.kind == Profile::Kind::kTable) {
    out.first = static_cast<std::int32_t>(plan.knots.size());
    out.count = static_cast<std::int32_t>(profile.times.size());
    for (std::size_t i = 0; i < profile.times.size(); ++i) plan.knots.push_back({profile.times[i], profile.values[i]});
  } else if (profile.kind == Profile::Kind::kHarmonic) {
    out.first = static_cast<std::int32_t>(plan.harmonics.size());
    out.count = static_cast<std::int32_t>(profile.harmonics.size());
    plan.harmonics.insert(plan.harmonics.end(), profile.harmonics.begin(), profile.harmonics.end());
  }
  plan.profiles.push_back(out);
  return static_cast<std::int32_t>(plan.profiles.size()) - 1;
}

void compile_elements(const Model& model, Plan& plan) {
  std::int32_t element = 0;
  const auto next = [&](bool on) {
    plan.element_scales.push_back(on ? 1 : 0);
    return element++;
  };
  const Profile* previous = nullptr;
  for (const Load& l : model.loads) {
    plan.loads.push_back({l.body, next(l.on), compile_profile(l.profile, previous, plan), l.channel,
                          l.kind == Load::Kind::kTorque, l.frame == Load::Frame::kWorld, to_vec(l.point),
                          to_vec(l.direction)});
    previous = &l.profile;
  }
  for (const PointSpring& s : model.point_springs)
    plan.point_springs.push_back({s.base, s.follower, next(s.on), s.push_only, to_vec(s.point_base),
                                  to_vec(s.point_follower), s.stiffness, s.damping, s.free_length});
  for (const JointSpring& s : model.joint_springs)
    plan.joint_springs.push_back({s.joint, s.axis, next(s.on), s.effort, s.stiffness, s.damping, s.rest});
  for (const PlaneTorsion& s : model.plane_torsions)
    plan.plane_torsions.push_back(
        {s.base, s.follower, next(s.on), to_vec(s.normal_base), to_vec(s.axis_follower), s.stiffness, s.damping});
}

// Appends a guard in postfix order; returns how many values its evaluation keeps at once.
std::int32_t compile_condition(const Condition& c, Plan& plan) {
  std::int32_t depth = 1;
  for (std::size_t i = 0; i < c.parts.size(); ++i)
    depth = std::max(depth, static_cast<std::int32_t>(i) + compile_condition(c.parts[i], plan));
  plan.conditions.push_back(
      {c.kind, c.subject, c.axis, static_cast<std::int32_t>(c.parts.size()), c.threshold, c.below});
  return depth;
}

void compile_events(const Model& model, Plan& plan) {
  for (const Event& event : model.events) {
    PlanEvent out{
        static_cast<std::int32_t>(plan.conditions.size()), 0,           static_cast<std::int32_t>(plan.actions.size()),
        static_cast<std::int32_t>(event.then.size()),      event.delay, event.repeat};
    plan.guard_depth = std::max(plan.guard_depth, compile_condition(event.when, plan));
    out.condition_count = static_cast<std::int32_t>(plan.conditions.size()) - out.first_condition;
    plan.actions.insert(plan.actions.end(), event.then.begin(), event.then.end());
    plan.events.push_back(out);
  }
}

void compile_sensors(const Model& model, Plan& plan) {
  for (const Sensor& s : model.sensors) {
    plan.sensors.push_back({s.kind, s.subject, s.axis, plan.sensor_count, to_vec(s.point)});
    plan.sensor_count += sensor_width(s.kind);
  }
}

void check_options(const Model& model, const PlanOptions& options, std::vector<ModelError>& errors) {
  if (!(options.dt > 0) || !std::isfinite(options.dt))
    errors.push_back(
        {"step", "dt is " + std::to_string(options.dt) + " s", "give a positive step, for example 0.001 s"});
  if (options.max_splits < 1)
    errors.push_back(
        {"step", "max_splits is " + std::to_string(options.max_splits), "allow at least one event per step"});
  if (!is_supported(options.lanes))
    errors.push_back({"step", std::string("this build or this processor has no ") + get_name(options.lanes),
                      "leave the lanes to be chosen"});
  if (options.root < kNone || options.root >= static_cast<int>(model.bodies.size()))
    errors.push_back({"step", "root is not a body of the model", "name one of its bodies, or leave it out"});
}

}  // namespace

PlanResult compile_plan(const Model& model, const PlanOptions& options) {
  PlanResult result;
  result.errors = validate(model);
  check_options(model, options, result.errors);
  if (!result.errors.empty()) return result;

  Plan plan;
  plan.options = options;
  Topology topology = compile_topology(model, options.root);
  plan.nodes = std::move(topology.nodes);
  plan.loops = std::move(topology.loops);

  for (const Body& body : model.bodies) plan.bodies.push_back(compile_body(body));
  compile_events(model, plan);
  const std::vector<ReadCoordinates> read = find_read_coordinates(model, plan.conditions);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    plan.joints.push_back(compile_joint(model, model.joints[j], read[j], static_cast<int>(plan.modes.size())));
    if (read[j].by_any != 0) plan.measured_joints.push_back(static_cast<std::int32_t>(j));
    for (const JointMode& mode : model.joints[j].modes) plan.modes.push_back(mode.rows);
  }
  compile_lanes(model, plan);
  plan.kernels = &get_kernels(options.lanes);
  plan.gravity = to_vec(model.gravity.uniform);
  plan.mu = model.gravity.mu;
  plan.mu_centre = to_vec(model.gravity.centre);
  compile_elements(model, plan);
  compile_sensors(model, plan);
  plan.signal_count = static_cast<std::int32_t>(model.signals.size());
  plan.channel_count = static_cast<std::int32_t>(model.channels.size());
  plan.hash = calc_model_hash(model, options);
  result.plan = std::move(plan);
  return result;
}

}  // namespace unlatch
