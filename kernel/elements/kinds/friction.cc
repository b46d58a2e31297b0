#include "kernel/elements/kinds/friction.h"

#include <algorithm>
#include <cmath>

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

}  // namespace unlatch
