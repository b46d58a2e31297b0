#include "kernel/events/impulses.h"

#include "kernel/joints/kinematics.h"

namespace unlatch {
namespace {

// Calls f(impulse) for each impulse of the events that act.
template <class F>
void for_each(const PlanData& plan, std::span<const std::int64_t> acting, F f) {
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    if (acting[e] == 0) continue;
    for (int i = 0; i < plan.events[e].action_count; ++i) {
      const Action& action = plan.actions[at(plan.events[e].first_action + i)];
      if (action.kind == Action::Kind::kImpulse) f(plan.impulses[at(action.subject)]);
    }
  }
}

// An impulse in world axes, and its arm from the body's origin.
struct Turned {
  Vec3 arm, linear, angular;
};
Turned turn(const PlanImpulse& own, const Inputs& inputs, const BodyFrame& body) {
  const double size = own.channel == kNone ? 1.0 : inputs.commands[at(own.channel)];
  return {body.R * own.point, size * (own.world ? own.linear : body.R * own.linear),
          size * (own.world ? own.angular : body.R * own.angular)};
}

}  // namespace

bool has_impulses(const PlanData& plan, std::span<const std::int64_t> acting) noexcept {
  if (plan.impulses.empty()) return false;
  bool any = false;
  for_each(plan, acting, [&](const PlanImpulse&) { any = true; });
  return any;
}

Source set_impulses(const PlanData& plan, const Inputs& inputs, std::span<const std::int64_t> acting,
                    Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (const Place& place : plan.places) write(blocks, place, &SharedLane::force, {{0, 0, 0}, {0, 0, 0}});
  for_each(plan, acting, [&](const PlanImpulse& own) {
    const Turned t = turn(own, inputs, get_body_frame(ev, own.body));
    add(blocks, ev.places[at(own.body)], &SharedLane::force, {t.linear, cross(t.arm, t.linear) + t.angular});
  });
  return Source::kBodyForces;
}

Balance calc_impulses(const PlanData& plan, const Inputs& inputs, std::span<const std::int64_t> acting,
                      const Evaluation& ev) noexcept {
  Balance sum{{0, 0, 0}, {0, 0, 0}, 0};
  for_each(plan, acting, [&](const PlanImpulse& own) {
    const BodyFrame body = get_body_frame(ev, own.body);
    const Turned t = turn(own, inputs, body);
    sum.momentum += t.linear;
    sum.angular_momentum += cross(body.p + t.arm, t.linear) + t.angular;
    sum.kinetic += 0.5 * (dot(t.linear, body.v + cross(body.w, t.arm)) + dot(t.angular, body.w));
  });
  return sum;
}

}  // namespace unlatch
