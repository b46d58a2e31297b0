#include "kernel/dynamics/planet_forces.h"

#include "kernel/environment/field.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

bool is_marker(const PlanData& plan, std::size_t b) {
  const std::int32_t flexible = plan.bodies[b].flexible;
  return flexible != kNone && at(plan.flexible[at(flexible)].body) != b;
}

Vec3 calc_torque(const PlanData& plan, const Vec3& origin, const Evaluation& ev, std::size_t b) {
  if (!plan.environment.planet.gradient_torque) return {0, 0, 0};
  const PlanBody& body = plan.bodies[b];
  Vec3 p = read(ev.blocks.data(), ev.places[b], &BodyLane::motion).p;
  if (body.varying != kNone) p += ev.varying[at(body.varying)].centre;
  return calc_gradient_torque(plan.environment.planet, origin, p, read_kinematics(ev, static_cast<int>(b)).J);
}

}  // namespace

void add_planet_forces(const PlanData& plan, const Vec3& origin, Evaluation& ev) noexcept {
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    if (is_marker(plan, b)) continue;
    const PlanBody& body = plan.bodies[b];
    Vec3 weight{0, 0, 0};
    if (body.flexible == kNone && body.varying == kNone) {
      const Vec3 p = read(ev.blocks.data(), ev.places[b], &BodyLane::motion).p;
      weight = body.mass * calc_planet_gravity(plan.environment.planet, origin, p);
    }
    add(ev.blocks.data(), ev.places[b], &SharedLane::force, {weight, calc_torque(plan, origin, ev, b)});
  }
}

double calc_gradient_power(const PlanData& plan, const Vec3& origin, const Evaluation& ev) noexcept {
  double power = 0;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b)
    if (!is_marker(plan, b)) power += dot(calc_torque(plan, origin, ev, b), read_kinematics(ev, static_cast<int>(b)).w);
  return power;
}

}  // namespace unlatch
