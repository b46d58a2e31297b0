#include "kernel/dynamics/energy.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "kernel/dynamics/balance.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/elements/contacts.h"
#include "kernel/elements/gravity.h"
#include "kernel/elements/loads.h"
#include "kernel/elements/one_sided.h"
#include "kernel/elements/springs.h"
#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "unlatch/energy.h"

namespace unlatch {
namespace {

// The sum under way, for an observer with the velocity `frame`.
struct Sum {
  EnergyFlow flow{};
  Vec3 frame;

  // Adds the power of a force, N, on a point that moves with v, m/s; both in world axes.
  void push(PowerSource source, const Vec3& force, const Vec3& v) {
    flow.power[at(static_cast<int>(source))] += dot(force, v - frame);
    flow.force[at(static_cast<int>(source))] += force;
  }
  // Adds a power of internal forces, W: the same for every observer.
  void add(PowerSource source, double power) { flow.power[at(static_cast<int>(source))] += power; }

  void add_body(double mass, const Vec3& v, double spin_energy) {
    const Vec3 seen = v - frame;
    flow.mass += mass;
    flow.momentum += mass * seen;
    flow.kinetic += 0.5 * mass * dot(seen, seen) + spin_energy;
  }
};

// Part of a switch scale that is gained per second.
double calc_scale_rate(const ElementState& element, double t) {
  const double elapsed = t - element.start;
  return elapsed >= 0 && elapsed < element.duration ? (element.to - element.from) / element.duration : 0;
}

// A potential, times the switch scale.
void store(Sum& sum, const ElementState& element, double t, double scale, double energy) {
  sum.flow.strain += scale * energy;
  sum.add(PowerSource::kSwitching, calc_scale_rate(element, t) * energy);
}
// ½ k x²
void store(Sum& sum, const ElementState& element, double t, double scale, double stiffness, double x) {
  store(sum, element, t, scale, 0.5 * stiffness * x * x);
}

// T = ½ m |v_c|² + ½ w·J w with dm/dt, dc/dt and dJ/dt beside the motion that varying.h describes, and the power of its
// jet damping.
void add_varying_body(const PlanData& plan, const Evaluation& ev, std::int32_t varying, const BodyFrame& body,
                      const BodyKinematics& k, Sum& sum) {
  const PlanVarying& law = plan.varying[at(varying)];
  const VaryingBody& b = ev.varying[at(varying)];
  const double rate = law.by_burnt ? ev.auxiliary.rate[at(varying)] : 1;
  const Vec3 v = body.v + cross(k.w, b.centre);
  const Vec3 change = rotate(k.R, b.inertia_slope_B) * k.w;
  sum.add_body(b.mass, v, 0.5 * dot(k.w, k.J * k.w));
  sum.push(PowerSource::kGravity, b.mass * calc_gravity(plan.gravity, body.p + b.centre), v);
  sum.push(PowerSource::kMass, b.mass * cross(k.w, k.R * (rate * b.centre_slope_B)), v);
  // ½ dm/dt |v|²: for another observer less dm/dt v per velocity, and dm/dt / 2 per its square
  const Vec3 seen = v - sum.frame;
  const double lost = rate * b.mass_slope;
  sum.flow.mass_rate += lost;
  sum.flow.power[at(static_cast<int>(PowerSource::kMass))] += 0.5 * lost * dot(seen, seen);
  sum.flow.force[at(static_cast<int>(PowerSource::kMass))] += lost * seen;
  sum.add(PowerSource::kMass, 0.5 * rate * dot(k.w, change));
  if (!law.jet_damping) return;
  const Vec3 r = k.R * law.exit - b.centre;
  sum.add(PowerSource::kMass, rate * dot(k.w, b.mass_slope * cross(r, cross(k.w, r)) - change));
}

void add_flexible_body(const PlanData& plan, const State& state, const PlanFlexible& flexible, Sum& sum) {
  BodyState seen = state.bodies[at(flexible.body)];
  const Vec3 g = calc_gravity(plan.gravity, seen.p);
  const double* coordinates = state.auxiliary.data() + flexible.auxiliary;
  seen.v = seen.v - sum.frame;
  const Balance own = calc_flexible_balance(plan, flexible, seen, coordinates);
  sum.flow.mass += flexible.mass;
  sum.flow.momentum += own.momentum;
  sum.flow.kinetic += own.kinetic;
  sum.add(PowerSource::kGravity, dot(g, own.momentum));
  sum.flow.force[at(static_cast<int>(PowerSource::kGravity))] += flexible.mass * g;
  const ModalShape shape = get_shape(plan, flexible);
  for (int k = 0; k < flexible.modes; ++k) {
    const double eta = coordinates[k], rate = coordinates[flexible.modes + k];
    sum.flow.strain += 0.5 * shape.stiffness[k] * eta * eta;
    sum.add(PowerSource::kModes, -shape.damping[k] * rate * rate);
  }
}

void add_bodies(const PlanData& plan, const State& state, const Evaluation& ev, Sum& sum) {
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const PlanBody& body = plan.bodies[b];
    if (body.flexible != kNone) {
      const PlanFlexible& flexible = plan.flexible[at(body.flexible)];
      if (flexible.body == static_cast<int>(b)) add_flexible_body(plan, state, flexible, sum);
      continue;
    }
    const BodyKinematics k = read_kinematics(ev, static_cast<int>(b));
    if (body.varying != kNone) {
      add_varying_body(plan, ev, body.varying, get_body_frame(ev, static_cast<int>(b)), k, sum);
      continue;
    }
    const BodyState& s = state.bodies[b];
    sum.add_body(body.mass, s.v, 0.5 * dot(k.w, k.J * k.w));
    sum.push(PowerSource::kGravity, body.mass * calc_gravity(plan.gravity, s.p), s.v);
  }
}

void add_loads(const PlanData& plan, const Evaluation& ev, Sum& sum) {
  for (std::size_t i = 0; i < plan.loads.size(); ++i) {
    const PlanLoad& load = plan.loads[i];
    const double size = ev.load_sizes[i];
    if (size == 0) continue;
    const BodyFrame body = get_body_frame(ev, load.body);
    const Vec3 force = size * (load.world ? load.wrench.lin : body.R * load.wrench.lin);
    const Vec3 torque = size * (load.world ? load.wrench.ang : body.R * load.wrench.ang);
    const Vec3 v = load.world ? body.v + cross(body.w, body.R * load.point) : body.v;
    sum.push(PowerSource::kLoads, force, v);
    sum.add(PowerSource::kLoads, dot(torque, body.w));
  }
}

void add_point_springs(const PlanData& plan, const State& state, double t, const Evaluation& ev, Sum& sum) {
  for (const PlanPointSpring& spring : plan.point_springs) {
    const ElementState& element = state.elements[at(spring.element)];
    const double scale = calc_scale(element, t);
    const PointSpringForce f =
        calc_force(spring, get_body_frame(ev, spring.base), get_body_frame(ev, spring.follower), scale);
    const double stretch = f.length - spring.free_length;
    if (spring.push_only && stretch >= 0) continue;
    store(sum, element, t, scale, spring.stiffness, stretch);
    sum.add(PowerSource::kDampers, f.viscous * f.rate);
  }
}

// A torsion about an axis of the rotation frame has a potential while the two other rotations are held.
bool has_potential(RowSet rows, int axis) {
  const auto others = static_cast<RowSet>(kRotationRows & static_cast<RowSet>(~row_bit(axis)));
  return axis < kRotX || (rows & others) == others;
}

void add_joint_springs(const PlanData& plan, const State& state, double t, const Evaluation& ev, Sum& sum) {
  for (const PlanJointSpring& spring : plan.joint_springs) {
    const ElementState& element = state.elements[at(spring.element)];
    const double scale = calc_scale(element, t);
    const double stretch = ev.coordinates[at(spring.coordinate)] - spring.rest;
    const double rate = ev.speeds[at(spring.coordinate)];
    double effort = spring.effort * scale;
    if (has_potential(get_active_rows(plan, state, spring.joint), spring.axis))
      store(sum, element, t, scale, spring.stiffness, stretch);
    else
      effort -= spring.stiffness * stretch * scale;
    sum.add(PowerSource::kMotors, effort * rate);
    sum.add(PowerSource::kDampers, -spring.damping * scale * rate * rate);
  }
}

void add_plane_torsions(const PlanData& plan, const State& state, double t, const Evaluation& ev, Sum& sum) {
  for (const PlanPlaneTorsion& spring : plan.plane_torsions) {
    const ElementState& element = state.elements[at(spring.element)];
    const double scale = calc_scale(element, t);
    const PlaneTorsionForce f =
        calc_force(spring, get_body_frame(ev, spring.base), get_body_frame(ev, spring.follower), scale);
    store(sum, element, t, scale, spring.stiffness, f.angle);
    sum.add(PowerSource::kDampers, -spring.damping * scale * f.rate * f.rate);
  }
}

// Energy that closed pairs store, and all that contacts have lost.
void add_contacts(const PlanData& plan, const State& state, double t, const Evaluation& ev, Sum& sum) {
  for (const PlanContact& contact : plan.contacts) {
    sum.flow.dissipated +=
        state.auxiliary[at(contact.auxiliary) + offsetof(ContactTotals, dissipated) / sizeof(double)];
    const ElementState& element = state.elements[at(contact.element)];
    const double scale = calc_scale(element, t);
    if (scale == 0) continue;
    for (std::size_t i = at(contact.first_pair); i < at(contact.first_pair + contact.pairs); ++i) {
      if (state.contacts[i].closed == 0) continue;
      const double energy = calc_stored(contact, -ev.pair_distances[i]);
      sum.flow.strain += scale * energy;
      sum.add(PowerSource::kSwitching, calc_scale_rate(element, t) * energy);
    }
  }
}

// Energy stored within reach goes into the force or is lost. At the event that ends a push the depth is 0 but for
// rounding, and the force still acts: the power before the event. After it nothing acts and nothing is lost.
void add_one_sided(const PlanData& plan, const State& state, double t, const Evaluation& ev, Sum& sum) {
  for (const PlanOneSided& own : plan.one_sided) {
    const OneSidedMotion m = calc_motion(plan, state, ev, own);
    if (state.engaged[at(own.number)] == 0 && ends_with_depth(plan, own, m)) continue;
    const ElementState& element = state.elements[at(own.element)];
    const double scale = calc_scale(element, t);
    const OneSidedLaw law = get_law(plan, own);
    store(sum, element, t, scale, calc_stored_energy(law, std::max(0.0, m.depth)));
    const double force = calc_force(plan, state, t, own, m);
    sum.add(PowerSource::kDampers, (scale * calc_elastic_force(law, m.depth) - force) * m.depth_rate);
  }
}

void add_frictions(const PlanData& plan, const Evaluation& ev, Sum& sum) {
  for (std::size_t i = 0; i < plan.frictions.size(); ++i)
    sum.add(PowerSource::kDampers, ev.friction_sizes[i] * ev.speeds[at(plan.frictions[i].coordinate)]);
}

// A body is held to the ground, by rows or by an element that is on.
bool is_grounded(const PlanData& plan, const State& state, double t) {
  const auto pulls = [&](std::int32_t base, std::int32_t element) {
    return base == kGround && calc_scale(state.elements[at(element)], t) != 0;
  };
  for (std::size_t j = 0; j < plan.joints.size(); ++j)
    if (plan.joints[j].base == kGround && get_active_rows(plan, state, static_cast<int>(j)) != 0) return true;
  for (const PlanPointSpring& spring : plan.point_springs)
    if (pulls(spring.base, spring.element)) return true;
  for (const PlanJointSpring& spring : plan.joint_springs)
    if (pulls(plan.joints[at(spring.joint)].base, spring.element)) return true;
  for (const PlanPlaneTorsion& spring : plan.plane_torsions)
    if (pulls(spring.base, spring.element)) return true;
  for (const PlanContact& contact : plan.contacts)
    for (const std::int32_t shapes : {contact.base, contact.follower})
      if (pulls(plan.shapes[at(shapes)].body, contact.element)) return true;
  for (const PlanOneSided& own : plan.one_sided)
    if (state.engaged[at(own.number)] != 0 && pulls(own.base, own.element)) return true;
  for (const PlanFriction& own : plan.frictions)
    if (pulls(plan.joints[at(own.joint)].base, own.element)) return true;
  return false;
}

}  // namespace

const char* const kPowerSourceNames[kPowerSources] = {"loads", "gravity", "motors",   "dampers",
                                                      "modes", "mass",    "switching"};

EnergyFlow calc_energy_flow(const PlanData& plan, const State& state, double t, const Evaluation& ev,
                            const Vec3& frame) noexcept {
  Sum sum{{}, frame};
  add_bodies(plan, state, ev, sum);
  add_loads(plan, ev, sum);
  add_point_springs(plan, state, t, ev, sum);
  add_joint_springs(plan, state, t, ev, sum);
  add_plane_torsions(plan, state, t, ev, sum);
  add_contacts(plan, state, t, ev, sum);
  add_one_sided(plan, state, t, ev, sum);
  add_frictions(plan, ev, sum);
  return sum.flow;
}

EnergyFlow calc_energy_flow(const Plan& plan, const State& state, const Workspace& workspace,
                            const Vec3& frame) noexcept {
  return calc_energy_flow(plan.data(), state, plan.data().get_time(state.header->tick),
                          workspace.data().kept.evaluation, frame);
}

EnergyFlow change_frame(const EnergyFlow& flow, const Vec3& change) noexcept {
  EnergyFlow out = flow;
  out.kinetic += 0.5 * flow.mass * dot(change, change) - dot(flow.momentum, change);
  out.momentum -= flow.mass * change;
  for (int i = 0; i < kPowerSources; ++i) out.power[at(i)] -= dot(flow.force[at(i)], change);
  const int mass = static_cast<int>(PowerSource::kMass);
  out.power[at(mass)] += 0.5 * flow.mass_rate * dot(change, change);
  out.force[at(mass)] -= flow.mass_rate * change;
  return out;
}

Vec3 calc_audit_frame(const Plan& owner, const State& state, const Workspace& workspace) noexcept {
  const PlanData& plan = owner.data();
  if (is_grounded(plan, state, plan.get_time(state.header->tick))) return {0, 0, 0};
  Vec3 momentum = {0, 0, 0};
  double mass = 0;
  const Evaluation& ev = workspace.data().kept.evaluation;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const PlanBody& body = plan.bodies[b];
    double own = body.mass;
    if (body.varying != kNone) own = ev.varying[at(body.varying)].mass;
    if (body.flexible != kNone && plan.flexible[at(body.flexible)].body == static_cast<int>(b))
      own = plan.flexible[at(body.flexible)].mass;
    mass += own;
    momentum += own * state.bodies[b].v;
  }
  return (1 / mass) * momentum;
}

double calc_drift(const Plan& plan, const State& state, const Workspace& workspace) noexcept {
  return calc_drift(plan.data(), state, workspace.data().kept.evaluation);
}

}  // namespace unlatch
