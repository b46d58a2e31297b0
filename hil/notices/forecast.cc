#include "hil/notices/forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "hil/language/count.h"
#include "hil/motion/clearance.h"
#include "hil/notices/contact_resolution.h"
#include "hil/notices/format.h"
#include "hil/notices/friction_resolution.h"
#include "hil/notices/notices.h"
#include "hil/notices/resolution.h"
#include "hil/scenario/index.h"
#include "hil/scenario/requirements_check.h"
#include "unlatch/inertia.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

using Vector = Eigen::Vector3d;
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979323846;

std::string quoted(const char* kind, const std::string& name) { return std::string(kind) + " '" + name + "'"; }

// --- Places ---------------------------------------------------------------------------------------------------------

Pose get_pose(const Model& model, int body) {
  if (body == kGround) return {};
  const Body& b = model.bodies[at(body)];
  return {b.p_WB, Eigen::Quaterniond(b.q_WB.normalized())};
}
Vector place(const Pose& pose, const Vector& p) { return pose.p_WB + pose.q_WB * p; }

Vector calc_displacement(const Model& model, const Joint& joint) {
  const Pose base = get_pose(model, joint.base), follower = get_pose(model, joint.follower);
  const Vector gap = place(follower, joint.point_follower) - place(base, joint.point_base);
  return joint.axes.transpose() * (base.q_WB.conjugate() * gap);
}

// Angle about axis 0, 1, 2 of the rotation frame: for a hinge, its angle.
double calc_angle(const Model& model, const Joint& joint, int axis) {
  if (!joint.follower_axes) return 0;
  const Eigen::Matrix3d base =
      get_pose(model, joint.base).q_WB.toRotationMatrix() * joint.rotation_axes.value_or(joint.axes);
  const Eigen::Matrix3d follower = get_pose(model, joint.follower).q_WB.toRotationMatrix() * *joint.follower_axes;
  const Eigen::Matrix3d R = base.transpose() * follower;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  return std::atan2(R(v, u) - R(u, v), R(u, u) + R(v, v));
}

// --- Springs --------------------------------------------------------------------------------------------------------

SpringStart start_point_spring(const Model& model, const PointSpring& s) {
  SpringStart out{s.name, s.push_only ? "pusher" : "spring", s.on};
  out.length =
      (place(get_pose(model, s.follower), s.point_follower) - place(get_pose(model, s.base), s.point_base)).norm();
  const double stretch = out.length - s.free_length;
  if (s.push_only && stretch >= 0) return out;
  out.force = -s.stiffness * stretch;
  out.energy = 0.5 * s.stiffness * stretch * stretch;
  out.stroke = std::abs(stretch);
  return out;
}

SpringStart start_joint_spring(const Model& model, const JointSpring& s) {
  const Joint& joint = model.joints[at(s.joint)];
  SpringStart out{s.name, "joint spring", s.on, s.axis >= kRotX};
  out.length = out.angular ? calc_angle(model, joint, s.axis - kRotX) : calc_displacement(model, joint)[s.axis];
  const double stretch = out.length - s.rest;
  out.force = s.effort - s.stiffness * stretch;
  out.energy = 0.5 * s.stiffness * stretch * stretch;
  out.stroke = s.stiffness > 0 ? std::abs(s.rest + s.effort / s.stiffness - out.length) : 0;
  return out;
}

SpringStart start_torsion(const Model& model, const PlaneTorsion& s) {
  SpringStart out{s.name, "torsion", s.on, true};
  const Vector n = get_pose(model, s.base).q_WB * s.normal_base, a = get_pose(model, s.follower).q_WB * s.axis_follower;
  out.length = std::atan2(n.dot(a), n.cross(a).norm());
  out.force = s.stiffness * out.length;
  out.energy = 0.5 * s.stiffness * out.length * out.length;
  out.stroke = std::abs(out.length);
  return out;
}

SpringStart start_one_sided(const Model& model, const OneSided& f) {
  const char* const kinds[] = {"pusher", "stop", "cord"};
  SpringStart out{f.name, kinds[static_cast<int>(f.kind)], f.on, f.joint != kNone && f.axis >= kRotX};
  out.length = calc_start(model, f);
  const double sign = f.pulls ? -1 : 1, depth = sign * (calc_limit(model, f) - out.length);
  if (depth < 0) return out;
  out.force = sign * calc_one_sided_force(f, depth, 0);
  out.energy = calc_one_sided_energy(f, depth);
  out.stroke = depth;
  return out;
}

void find_directionless(const Model& model, std::vector<Finding>& findings) {
  for (const PointSpring& s : model.point_springs) {
    const double length = start_point_spring(model, s).length, force = s.stiffness * s.free_length;
    if (length > kCoincident || force == 0) continue;
    findings.push_back({"direction", quoted("element", s.name),
                        format("its two points coincide, to %.1g m, with %.4g N in it: the force has no direction, and "
                               "rounding picks one or none; move one of the points along the line of the force",
                               length, force)});
  }
  for (const OneSided& f : model.one_sided) {
    if (f.joint != kNone || f.guide || f.kind == OneSided::Kind::kCord) continue;
    const SpringStart start = start_one_sided(model, f);
    if (start.length > kCoincident || start.force == 0) continue;
    findings.push_back(
        {"direction", quoted("element", f.name),
         format("its two points coincide, to %.1g m, with %.4g N in it: the force has no direction; give "
                "it a `guide`, or move one of the points along the line of the force",
                start.length, start.force)});
  }
}

bool frees_with(const Event& event, int joint, const Model& model, int element) {
  bool frees = false, switches = false;
  for (const Action& action : event.then) {
    const bool is_switch = action.kind == Action::Kind::kSwitch || action.kind == Action::Kind::kRamp;
    if (action.kind == Action::Kind::kSetMode && action.subject == joint)
      frees = model.joints[at(joint)].modes[at(action.mode)].rows == 0;
    if (is_switch && action.subject == element && action.value == 0) switches = true;
  }
  return frees && !switches;
}

void find_free_springs(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  const auto first = static_cast<int>(model.loads.size() + model.point_springs.size());
  for (std::size_t i = 0; i < model.joint_springs.size(); ++i) {
    const JointSpring& s = model.joint_springs[i];
    const auto& meant = scenario.springs_while_free;
    if (std::find(meant.begin(), meant.end(), s.name) != meant.end()) continue;
    const Joint& joint = model.joints[at(s.joint)];
    // A joint without rows in any mode exists for its springs only.
    const bool ever_holds =
        std::any_of(joint.modes.begin(), joint.modes.end(), [](const JointMode& mode) { return mode.rows != 0; });
    const bool stays = std::any_of(model.events.begin(), model.events.end(), [&](const Event& event) {
      return frees_with(event, s.joint, model, first + static_cast<int>(i));
    });
    if (!ever_holds || !stays) continue;
    findings.push_back({"free_spring", quoted("element", s.name),
                        "acts on after joint '" + joint.name +
                            "' is set free; switch it off in that event, or say `while_free: true`"});
  }
}

// --- Joints and bodies ----------------------------------------------------------------------------------------------

void find_joint_surprises(const Model& model, std::vector<Finding>& findings) {
  constexpr double kBranch = 1e-6, kApart = 1e-6;  // rad; m
  for (const Joint& joint : model.joints) {
    const RowSet rows = joint.modes[at(joint.mode)].rows;
    for (int axis = 0; axis < 3; ++axis) {
      const double angle = calc_angle(model, joint, axis);
      const auto others = static_cast<RowSet>(kRotationRows & static_cast<RowSet>(~row_bit(kRotX + axis)));
      if ((rows & kRotationRows) != others || kPi - std::abs(angle) > kBranch) continue;
      findings.push_back(
          {"branch", quoted("joint", joint.name),
           format("begins within 1e-6 rad of half a turn from its zero: rounding picks whether its angle "
                  "is +pi or -pi, here %+.9g rad; begin a little to one side, or take another zero",
                  angle)});
    }
    const Vector gap = calc_displacement(model, joint);
    double apart = 0;
    for (int row = kX; row <= kZ; ++row)
      if (has_row(rows, row)) apart = std::max(apart, std::abs(gap[row]));
    if (apart > kApart)
      findings.push_back({"points", quoted("joint", joint.name),
                          format("its points do not meet: %.6g, %.6g, %.6g m apart along its x, y, z; it holds them so",
                                 gap.x(), gap.y(), gap.z())});
  }
}

void find_plates(const Model& model, std::vector<Finding>& findings) {
  constexpr double kRounding = 1e-9;  // relative
  for (const Body& body : model.bodies) {
    if (body.marker || !(body.inertia.trace() > 0)) continue;
    const Vector m = calc_principal_moments(body.inertia);
    if (m[0] + m[1] >= m[2] * (1 - kRounding)) continue;
    findings.push_back({"inertia", quoted("body", body.name),
                        format("its largest principal moment exceeds the sum of the others by %.2g of it: a plate's, "
                               "rounded; no body has that, and it is taken as it is",
                               1 - (m[0] + m[1]) / m[2])});
  }
}

// Finds bodies that overlap at the start, among those that no joint, contact or watched pair allows to meet.
void find_intruders(const Scenario& scenario, std::vector<Finding>& findings) {
  constexpr double kTouching = 1e-6;  // relative to the smaller body: mated faces
  constexpr std::size_t kMost = 10;
  const Model& model = scenario.model;
  std::set<std::pair<int, int>> meet;
  // Markers count as the flexible body that carries them.
  const auto get_structure = [&](int body) {
    const bool carried = body != kGround && model.bodies[at(body)].marker.has_value();
    return carried ? model.bodies[at(body)].marker->body : body;
  };
  const auto let_meet = [&](int a, int b) { meet.insert(std::minmax(get_structure(a), get_structure(b))); };
  for (const ClearancePair& pair : scenario.clearance) let_meet(pair.a.body, pair.b.body);
  for (const Contact& contact : model.contacts)
    let_meet(model.surfaces[at(contact.base)].body, model.surfaces[at(contact.follower)].body);
  for (const Joint& joint : model.joints) let_meet(joint.base, joint.follower);

  struct Solid {
    int body;
    geometry::ShapeGroup group;
    geometry::Placement place;
  };
  std::vector<Solid> solids;
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) {
    std::vector<geometry::Shape> shapes;
    for (const BodyShape& shape : scenario.shapes[at(b)])
      if (!shape.mesh) shapes.push_back(shape.shape);  // meshes have no depth
    if (!shapes.empty())
      solids.push_back({b, geometry::build_group(model.bodies[at(b)].name, shapes), to_placement(get_pose(model, b))});
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    for (std::size_t i = 0; i < k; ++i) {
      const Solid &a = solids[i], &b = solids[k];
      const std::pair<int, int> pair = std::minmax(get_structure(a.body), get_structure(b.body));
      if (pair.first == pair.second || meet.contains(pair) ||
          geometry::calc_lower_bound(a.group, a.place, b.group, b.place) > 0)
        continue;
      const double depth = -geometry::calc_distance(a.group, a.place, b.group, b.place).least.distance;
      if (!(depth > kTouching * std::min(a.group.bound, b.group.bound)) || ++count > kMost) continue;
      findings.push_back(
          {"overlap", quoted("body", model.bodies[at(b.body)].name),
           format("lies %.4g m within '%s' at the start, to which nothing joins it: move one of them, or "
                  "make the shapes smaller",
                  depth, model.bodies[at(a.body)].name.c_str())});
    }
  }
  if (count > kMost)
    findings.push_back(
        {"overlap", "bodies", hil::count(count - kMost, "more pair") + " within each other at the start"});
}

// Finds overlaps of watched pairs.
void find_overlaps(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  if (scenario.clearance.empty()) return;
  std::vector<Pose> poses;
  for (int b = 0; b < static_cast<int>(model.bodies.size()); ++b) poses.push_back(get_pose(model, b));
  ClearanceMonitor monitor(scenario.clearance, scenario.shapes);
  monitor.update(0, poses);
  for (const Clearance& c : monitor.get()) {
    if (c.now > 0) continue;
    if (c.method == DistanceMethod::kMesh && c.now == 0) {
      findings.push_back({"overlap", quoted("body", model.bodies[at(c.b)].name),
                          c.name_b + " touches or crosses " + c.name_a +
                              " at the start; their smallest clearance is 0: triangles have no depth. Leave out faces "
                              "that mate by `except`"});
      continue;
    }
    findings.push_back(
        {"overlap", quoted("body", model.bodies[at(c.b)].name),
         c.name_b + format(" touches or overlaps %s at the start, by %.4g m: their smallest clearance is that "
                           "or less. Leave out faces that mate by `except`",
                           c.name_a.c_str(), -c.now)});
  }
}

// --- Events ---------------------------------------------------------------------------------------------------------

// Earliest times at which modes, signals and events can occur, from known times, delays and dependencies. Guards of
// motion can be true at any time.
class Earliest {
 public:
  explicit Earliest(const Model& model) : model_(model), events(model.events.size(), kNever) {
    signals_.assign(model.signals.size(), kNever);
    for (const Joint& joint : model.joints) {
      modes_.emplace_back(joint.modes.size(), kNever);
      modes_.back()[at(joint.mode)] = 0;
    }
    // Each pass settles at least one event.
    for (std::size_t pass = 0; pass <= model.events.size(); ++pass) settle();
  }

 private:
  void settle() {
    for (std::size_t e = 0; e < events.size(); ++e) {
      const Event& event = model_.events[e];
      events[e] = std::min(events[e], calc(event.when) + event.delay);
      for (const Action& action : event.then) {
        if (action.kind == Action::Kind::kRaise) lower(signals_[at(action.subject)], events[e]);
        if (action.kind == Action::Kind::kSetMode) lower(modes_[at(action.subject)][at(action.mode)], events[e]);
      }
    }
  }
  static void lower(double& time, double to) { time = std::min(time, to); }

  [[nodiscard]] double calc(const Condition& c) const {
    using Kind = Condition::Kind;
    double time = c.kind == Kind::kAny ? kNever : 0;
    switch (c.kind) {
      case Kind::kTime:
        return c.below ? 0 : std::max(0.0, c.threshold);
      case Kind::kSignal:
        return signals_[at(c.subject)];
      case Kind::kMode:
        return modes_[at(c.subject)][at(c.axis)];
      case Kind::kReaction:
        time = kNever;
        for (std::size_t mode = 0; mode < modes_[at(c.subject)].size(); ++mode)
          if (has_row(model_.joints[at(c.subject)].modes[mode].rows, c.axis))
            time = std::min(time, modes_[at(c.subject)][mode]);
        return time;
      case Kind::kAll:
        for (const Condition& part : c.parts) time = std::max(time, calc(part));
        return time;
      case Kind::kAny:
        for (const Condition& part : c.parts) time = std::min(time, calc(part));
        return time;
      default:
        return 0;
    }
  }

  const Model& model_;
  std::vector<double> signals_;
  std::vector<std::vector<double>> modes_;

 public:
  std::vector<double> events;
};

// Name of an event in Scenario::marks.
std::string name_event(const Event& event) {
  return quoted("event", event.name) + (event.subject.empty() ? "" : " of '" + event.subject + "'");
}

bool has_kind(const Condition& c, Condition::Kind kind) {
  return c.kind == kind ||
         std::any_of(c.parts.begin(), c.parts.end(), [kind](const Condition& part) { return has_kind(part, kind); });
}
bool lies_before_start(const Condition& c) {
  if (c.kind == Condition::Kind::kTime) return !c.below && c.threshold < 0;
  return std::any_of(c.parts.begin(), c.parts.end(), lies_before_start);
}

void find_event_surprises(const Scenario& scenario, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  const Earliest earliest(model);
  for (std::size_t e = 0; e < model.events.size(); ++e) {
    const Event& event = model.events[e];
    const std::string where = name_event(event);
    if (earliest.events[e] == kNever)
      findings.push_back({"never", where, "cannot come: no event brings about what it waits for"});
    else if (earliest.events[e] > scenario.until)
      findings.push_back(
          {"never", where,
           format("cannot come before %.6g s; the run ends at %.6g s", earliest.events[e], scenario.until)});
    if (lies_before_start(event.when)) findings.push_back({"start", where, "waits for a time before the start"});
  }
  // A trial step shows which guards are true already; only guards on time matter.
  Simulation trial(model, {.dt = scenario.dt}, scenario.rates);
  for (const FiredEvent& fired : trial.step().events) {
    const Event& event = model.events[at(fired.event)];
    if (fired.time > 0 || has_kind(event.when, Condition::Kind::kTime)) continue;
    const std::string where = name_event(event);
    findings.push_back({"start", where, "holds at the start already, and acts at t = 0"});
  }
}

// --- The step -------------------------------------------------------------------------------------------------------

// Steps that a pusher's stroke, a ramp, a table's interval or a delay needs; ten of them locate its end to some 1e-3.
constexpr double kStepsToResolve = 10;

void add_short(const std::string& where, const char* what, double duration, double dt, std::vector<Finding>& findings) {
  if (!(duration > 0) || duration >= kStepsToResolve * dt) return;
  findings.push_back({"step", where,
                      format("%s takes %.4g s, %.2g steps of %.4g s: at least %.0f resolve it", what, duration,
                             duration / dt, dt, kStepsToResolve)});
}

void find_step_surprises(const Scenario& scenario, const Simulation& simulation, std::vector<Finding>& findings) {
  const Model& model = scenario.model;
  const double dt = scenario.dt;
  for (const SpringResolution& spring : calc_resolutions(simulation)) {
    const std::string where = quoted("element", model.element_name(spring.element));
    const auto i = static_cast<std::size_t>(spring.element) - model.loads.size();
    if (i < model.point_springs.size() && model.point_springs[i].push_only && spring.largest_omega > 0)
      add_short(where, "its stroke, a quarter of its period,", 0.5 * kPi / spring.largest_omega, dt, findings);
    const double worst = dt * spring.get_worst();
    if (worst > kAccurate)
      findings.push_back(
          {"step", where,
           format("h*omega or h*decay comes to %.3g%s%s%s: %s", worst, spring.where.empty() ? "" : " with ",
                  spring.where.c_str(), spring.implicit ? ", implicitly" : "",
                  spring.implicit   ? "second order, damps what the step does not resolve"
                  : worst > kStable ? "unstable; make the step smaller, or the element softer"
                                    : "stable, but not resolved accurately")});
  }
  for (const Load& load : model.loads) {
    const std::vector<double>& times = load.profile.times;
    double shortest = kNever;
    for (std::size_t i = 1; i < times.size(); ++i) shortest = std::min(shortest, times[i] - times[i - 1]);
    if (load.profile.kind == Profile::Kind::kTable && times.size() > 1 && shortest < dt)
      findings.push_back({"step", quoted("element", load.name),
                          format("its table has an interval of %.4g s, less than a step of %.4g s", shortest, dt)});
    if (load.profile.kind == Profile::Kind::kExponential && load.profile.tau < dt / kAccurate)
      findings.push_back(
          {"step", quoted("element", load.name),
           format("its time constant, %.4g s, is less than five steps of %.4g s", load.profile.tau, dt)});
  }
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    const Contact& contact = model.contacts[i];
    const std::string where = quoted("contact", contact.name);
    const ContactReading reading = calc_contact(simulation.plan(), simulation.state(), static_cast<int>(i));
    if (reading.closed)
      findings.push_back(
          {"contact", where, format("is closed at the start, %.4g m deep: that is no touch", reading.depth)});
    const double speed = estimate_speed(model, simulation.state(), contact);
    const std::string text =
        describe_unresolved(reading.closed ? calc_rates(model, simulation.state(), contact, reading)
                                           : estimate_rates(model, contact, speed),
                            dt / model.contact_substeps);
    const bool of_speed = !reading.closed && contact.exponent > 1;
    if (!text.empty())
      findings.push_back({"contact", where, text + (of_speed ? format(" (for a blow of %.3g m/s)", speed) : "")});
  }
  if (has_friction(model)) {
    const std::vector<ElementMobility> mobilities = calc_mobilities(simulation);
    for (const FrictionRate& rate : calc_friction_rates(simulation, mobilities))
      if (const std::string text = describe_unresolved(rate, dt); !text.empty())
        findings.push_back({"friction", quoted("element", model.element_name(rate.element)), text});
  }
  for (const Body& body : model.bodies) {
    const double size = body.w_WB_B.norm() * dt;
    if (!body.marker && size > kAccurate)
      findings.push_back(
          {"step", quoted("body", body.name), format("begins with |w|*h %.3g: beyond %.2g", size, kAccurate)});
  }
}

}  // namespace

std::vector<SpringStart> list_springs(const Scenario& scenario) {
  const Model model = place_markers(scenario.model);
  std::vector<SpringStart> springs;
  for (const PointSpring& s : model.point_springs) springs.push_back(start_point_spring(model, s));
  for (const JointSpring& s : model.joint_springs) springs.push_back(start_joint_spring(model, s));
  for (const PlaneTorsion& s : model.plane_torsions) springs.push_back(start_torsion(model, s));
  for (const OneSided& f : model.one_sided) springs.push_back(start_one_sided(model, f));
  return springs;
}

std::vector<Finding> find_surprises(const Scenario& scenario, const Simulation& simulation) {
  const Model model = place_markers(scenario.model);
  std::vector<Finding> findings;
  for (const Remark& remark : scenario.remarks) findings.push_back({remark.kind, remark.where, remark.text});
  find_plates(model, findings);
  find_joint_surprises(model, findings);
  find_directionless(model, findings);
  find_free_springs(scenario, findings);
  find_overlaps(scenario, findings);
  find_intruders(scenario, findings);
  find_event_surprises(scenario, findings);
  find_step_surprises(scenario, simulation, findings);
  for (const RequirementProblem& problem : find_trivial(scenario))
    findings.push_back({"trivial", quoted("requirement", scenario.requirements[problem.requirement].id),
                        problem.what + "; " + problem.mend});
  return findings;
}

}  // namespace unlatch::hil
