#include "kernel/dynamics/energy.h"

#include <algorithm>
#include <cmath>

#include "kernel/dynamics/balance.h"
#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/planet_forces.h"
#include "kernel/elements/gravity.h"
#include "kernel/elements/kinds/kinds.h"
#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"
#include "unlatch/energy.h"

namespace unlatch {
namespace {

// T = ½ m |v_c|² + ½ w·J w with dm/dt, dc/dt and dJ/dt beside the motion that varying.h describes, and the power of its
// jet damping.
void add_varying_body(const PlanData& plan, const Vec3& origin, const Evaluation& ev, std::int32_t varying,
                      const BodyFrame& body, const BodyKinematics& k, EnergySum& sum) {
  const PlanVarying& law = plan.varying[at(varying)];
  const VaryingBody& b = ev.varying[at(varying)];
  const double rate = law.by_burnt ? ev.auxiliary.rate[at(varying)] : 1;
  const Vec3 v = body.v + cross(k.w, b.centre);
  const Vec3 change = rotate(k.R, b.inertia_slope_B) * k.w;
  sum.add_body(b.mass, v, 0.5 * dot(k.w, k.J * k.w));
  sum.push(PowerSource::kGravity, b.mass * calc_free_fall(plan, origin, body.p + b.centre), v);
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

void add_flexible_body(const PlanData& plan, const State& state, const Vec3& origin, const PlanFlexible& flexible,
                       EnergySum& sum) {
  BodyState seen = state.bodies[at(flexible.body)];
  const Vec3 g = calc_free_fall(plan, origin, seen.p);
  const double* coordinates = state.auxiliary.data() + flexible.auxiliary;
  seen.v = seen.v - sum.frame;
  const Balance own = calc_flexible_balance(plan, flexible, seen, coordinates);
  sum.flow.mass += flexible.mass;
  sum.flow.momentum += own.momentum;
  sum.flow.kinetic += own.kinetic;
  sum.add(PowerSource::kGravity, dot(g, own.momentum));
  sum.flow.force[at(static_cast<int>(PowerSource::kGravity))] += flexible.mass * g;
  const ModalShape shape = get_shape(plan, flexible);
  for (std::size_t k = 0; k < shape.count_modes(); ++k) {
    const double eta = coordinates[k], rate = coordinates[shape.count_modes() + k];
    sum.flow.strain += 0.5 * shape.stiffness[k] * eta * eta;
    sum.add(PowerSource::kModes, -shape.damping[k] * rate * rate);
  }
}

void add_bodies(const PlanData& plan, const State& state, double t, const Evaluation& ev, EnergySum& sum) {
  const Vec3 origin = calc_origin_place(plan, t);
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const PlanBody& body = plan.bodies[b];
    if (body.flexible != kNone) {
      const PlanFlexible& flexible = plan.flexible[at(body.flexible)];
      if (flexible.body == static_cast<int>(b)) add_flexible_body(plan, state, origin, flexible, sum);
      continue;
    }
    const BodyKinematics k = read_kinematics(ev, static_cast<int>(b));
    if (body.varying != kNone) {
      add_varying_body(plan, origin, ev, body.varying, get_body_frame(ev, static_cast<int>(b)), k, sum);
      continue;
    }
    const BodyState& s = state.bodies[b];
    sum.add_body(body.mass, s.v, 0.5 * dot(k.w, k.J * k.w));
    sum.push(PowerSource::kGravity, body.mass * calc_free_fall(plan, origin, s.p), s.v);
  }
  if (plan.environment.exists) sum.add(PowerSource::kGravity, calc_gradient_power(plan, origin, ev));
}

template <class Kind>
void add_elements(const StageMotion& motion, EnergySum& sum) {
  const auto& list = Kind::of_plan(motion.plan());
  for (std::size_t i = 0; i < list.size(); ++i) {
    if constexpr (HasEffort<Kind>) {
      const ElementState& element = motion.state().elements[at(list[i].element)];
      const double scale = calc_scale(element, motion.time());
      const ElementEnergy energy = Kind::calc_energy(motion, list[i], Kind::calc(motion, list[i], i, scale), scale);
      sum.store(element, motion.time(), energy.potential);
      sum.add(PowerSource::kMotors, energy.motors);
      sum.add(PowerSource::kDampers, energy.dampers);
    } else {
      Kind::add_energy(motion, list[i], i, sum);
    }
  }
}

// A body is held to the ground, by rows or by an element that is on.
bool is_grounded(const PlanData& plan, const State& state, double t) {
  for (std::size_t j = 0; j < plan.joints.size(); ++j)
    if (plan.joints[j].base == kGround && get_active_rows(plan, state, static_cast<int>(j)) != 0) return true;
  bool grounded = false;
  for_each_kind([&]<class Kind>(Kind) {
    for (const auto& own : Kind::of_plan(plan))
      grounded =
          grounded || (Kind::holds_ground(plan, state, own) && calc_scale(state.elements[at(own.element)], t) != 0);
  });
  return grounded;
}

}  // namespace

const char* const kPowerSourceNames[kPowerSources] = {"loads", "gravity", "motors",   "dampers",
                                                      "modes", "mass",    "switching"};

EnergyFlow calc_energy_flow(const PlanData& plan, const State& state, double t, const Evaluation& ev,
                            const Vec3& frame) noexcept {
  EnergySum sum{{}, frame};
  add_bodies(plan, state, t, ev, sum);
  const Inputs none;  // energies depend on no command but by the sizes of loads, which are in the evaluation
  const Instant now{plan, none, state, t};
  for_each_kind([&]<class Kind>(Kind) { add_elements<Kind>({now, ev}, sum); });
  return sum.flow;
}

EnergyFlow calc_energy_flow(const Plan& plan, const State& state, const Workspace& workspace,
                            const Vec3& frame) noexcept {
  return calc_energy_flow(get_data(plan), state, get_data(plan).get_time(state.header->tick),
                          get_data(workspace).kept.evaluation, frame);
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

AuditFrame calc_audit_frame(const Plan& owner, const State& state, const Workspace& workspace) noexcept {
  const PlanData& plan = get_data(owner);
  if (is_grounded(plan, state, plan.get_time(state.header->tick))) return {.grounded = true};
  Vec3 momentum = {0, 0, 0};
  double mass = 0;
  const Evaluation& ev = get_data(workspace).kept.evaluation;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const PlanBody& body = plan.bodies[b];
    double own = body.mass;
    if (body.varying != kNone) own = ev.varying[at(body.varying)].mass;
    if (body.flexible != kNone && plan.flexible[at(body.flexible)].body == static_cast<int>(b))
      own = plan.flexible[at(body.flexible)].mass;
    Vec3 v = state.bodies[b].v;  // of the centre of mass
    if (body.varying != kNone)
      v += cross(read_kinematics(ev, static_cast<int>(b)).w, ev.varying[at(body.varying)].centre);
    mass += own;
    momentum += own * v;
  }
  return {.grounded = false, .velocity = (1 / mass) * momentum};
}

double calc_drift(const Plan& plan, const State& state, const Workspace& workspace) noexcept {
  return calc_drift(get_data(plan), state, get_data(workspace).kept.evaluation);
}

}  // namespace unlatch
