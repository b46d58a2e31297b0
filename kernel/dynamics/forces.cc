#include "kernel/dynamics/forces.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/planet_forces.h"
#include "kernel/dynamics/varying.h"
#include "kernel/elements/kinds/kinds.h"
#include "kernel/elements/push.h"

namespace unlatch {
namespace {

// Consumption of propellant, and loads that stand apart: in the world's axes, or sized by a law. init_forces() has the
// others.
void add_loads(const PlanData& plan, Evaluation& ev) {
  for (const std::int32_t i : plan.external_loads) {
    const PlanLoad& load = plan.loads[at(i)];
    const double size = ev.load_sizes[at(i)];
    if (load.consumption != 0) ev.auxiliary.rate[at(load.varying)] += load.consumption * std::abs(size) * load.length;
    if (!load.apart || size == 0) continue;
    const Mat3 R = read(ev.blocks.data(), ev.places[at(load.body)], &BodyLane::R);
    if (!load.world) {
      push(ev, load.body, R * (size * load.wrench.lin), R * (size * load.wrench.ang));
      continue;
    }
    const Vec3 force = size * load.wrench.lin;
    push(ev, load.body, force, cross(R * load.point, force) + size * load.wrench.ang);
  }
}

template <class Kind>
void add_efforts(const Instant& now, Evaluation& ev) {
  const auto& list = Kind::of_plan(now.plan);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto& own = list[i];
    const double scale = Kind::acts(now, ev, own, i) ? calc_scale(now.state.elements[at(own.element)], now.t) : 0;
    if (scale == 0) {
      if constexpr (requires { Kind::rest(own, ev); }) Kind::rest(own, ev);
      continue;
    }
    if constexpr (HasEffort<Kind>) {
      const Effort effort = Kind::calc(StageMotion{now, ev}, own, i, scale);
      if constexpr (requires { Kind::keep(own, effort, ev); }) Kind::keep(own, effort, ev);
      if (!effort.acts) continue;
      const Vec3 push = effort.size * effort.direction;
      push_apart(ev, effort.base, effort.follower,
                 effort.turns ? calc_wrenches(push) : calc_wrenches(effort.r_base, effort.r_follower, push));
    } else {
      Kind::add_forces(now, own, scale, ev);
    }
  }
}

// Of elements between two bodies: all kinds but loads.
void add_pair_forces(const Instant& now, Evaluation& ev) {
  for_each_kind([&]<class Kind>(Kind) {
    if constexpr (!std::is_same_v<Kind, LoadKind>) add_efforts<Kind>(now, ev);
  });
}

}  // namespace

void add_forces(const Instant& now, Evaluation& ev) noexcept {
  const PlanData& plan = now.plan;
  std::fill(ev.auxiliary.rate.begin(), ev.auxiliary.rate.end(), 0.0);
  add_loads(plan, ev);
  if (plan.pair_forces) add_pair_forces(now, ev);
  if (plan.plain) return;
  const Vec3 origin = calc_origin_place(plan, now.t);
  add_varying_forces(plan, origin, ev);
  add_flexible_forces(plan, origin, now.implicit, ev);
  if (plan.environment.exists) add_planet_forces(plan, origin, ev);
}

}  // namespace unlatch
