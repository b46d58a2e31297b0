#include "kernel/elements/friction.h"

#include <algorithm>
#include <cmath>

#include "kernel/elements/push.h"
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
    const double reaction = calc_reaction_size(ev, own.joint, kX);
    const double v = own.radius * ev.speeds[at(own.coordinate)];
    const double scale = calc_scale(now.state.elements[at(own.element)], now.t);
    ev.friction_sizes[i] =
        -(own.coefficient * own.radius * scale * reaction) * (v / std::sqrt(v * v + own.speed * own.speed));
  }
}

void add_friction_forces(const PlanData& plan, Evaluation& ev) noexcept {
  for (std::size_t i = 0; i < plan.frictions.size(); ++i) {
    const PlanFriction& own = plan.frictions[i];
    if (ev.friction_sizes[i] != 0) push_apart(ev, JointView(plan, ev, own.joint), own.axis, ev.friction_sizes[i]);
  }
}

}  // namespace unlatch
