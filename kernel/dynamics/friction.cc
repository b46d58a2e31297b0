#include "kernel/dynamics/friction.h"

#include <algorithm>
#include <cmath>

#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

bool acts(const Instant& now, const PlanFriction& own) {
  const RowSet rows = get_active_rows(now.plan, now.state, own.joint);
  return (rows & kPointRows) != 0 && !has_row(rows, own.axis) &&
         calc_scale(now.state.elements[at(own.element)], now.t) != 0;
}

}  // namespace

bool has_friction(const Instant& now) noexcept {
  for (const PlanFriction& own : now.plan.frictions)
    if (acts(now, own)) return true;
  return false;
}

void clear_friction(Evaluation& ev) noexcept { std::fill(ev.friction_sizes.begin(), ev.friction_sizes.end(), 0.0); }

void update_friction(const Instant& now, Evaluation& ev) noexcept {
  for (std::size_t i = 0; i < now.plan.frictions.size(); ++i) {
    const PlanFriction& own = now.plan.frictions[i];
    if (!acts(now, own)) continue;
    double square = 0;
    for (std::size_t r = 0; r < kRotX; ++r) {
      const double lambda = ev.multipliers.get(at(own.joint), r);
      square += lambda * lambda;
    }
    const double v = own.radius * ev.speeds[at(own.coordinate)];
    const double scale = calc_scale(now.state.elements[at(own.element)], now.t);
    ev.friction_sizes[i] =
        -(own.coefficient * own.radius * scale * std::sqrt(square)) * (v / std::sqrt(v * v + own.speed * own.speed));
  }
}

void add_friction_forces(const PlanData& plan, Evaluation& ev) noexcept {
  const auto push = [&](std::int32_t body, const Spatial& wrench) {
    if (body != kGround) add(ev.blocks.data(), ev.places[at(body)], &SharedLane::force, wrench);
  };
  for (std::size_t i = 0; i < plan.frictions.size(); ++i) {
    const double size = ev.friction_sizes[i];
    if (size == 0) continue;
    const PlanFriction& own = plan.frictions[i];
    const JointView joint(plan, ev, own.joint);
    const Vec3 vector = size * joint.get_axis(own.axis);
    if (own.axis >= kRotX) {
      push(joint.get_plan().follower, {{0, 0, 0}, vector});
      push(joint.get_plan().base, {{0, 0, 0}, -vector});
    } else {
      push(joint.get_plan().follower, {vector, cross(joint.get_arm(true), vector)});
      push(joint.get_plan().base, {-vector, -cross(joint.get_arm(false), vector)});
    }
  }
}

}  // namespace unlatch
