#include "kernel/dynamics/balance.h"

#include "kernel/dynamics/flexible.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {
Balance calc_balance(const PlanData& plan, const State& state, const Evaluation& ev) noexcept {
  Balance sum{{0, 0, 0}, {0, 0, 0}, 0};
  const auto add = [&](double mass, const Vec3& p, const Vec3& v, const BodyKinematics& k) {
    const Vec3 momentum = mass * v;
    const Vec3 spin = k.J * k.w;
    sum.momentum += momentum;
    sum.angular_momentum += cross(p, momentum) + spin;
    sum.kinetic += 0.5 * (dot(momentum, v) + dot(spin, k.w));
  };
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const BodyState& s = state.bodies[b];
    const BodyKinematics k = read_kinematics(ev, static_cast<int>(b));
    if (plan.bodies[b].flexible != kNone) {
      const PlanFlexible& flexible = plan.flexible[at(plan.bodies[b].flexible)];
      if (flexible.body != static_cast<int>(b)) continue;  // a marker
      const Balance own = calc_flexible_balance(plan, flexible, s, state.auxiliary.data() + flexible.auxiliary);
      sum.momentum += own.momentum;
      sum.angular_momentum += own.angular_momentum;
      sum.kinetic += own.kinetic;
    } else if (plan.bodies[b].varying == kNone) {
      add(plan.bodies[b].mass, s.p, s.v, k);
    } else {
      const VaryingBody& body = ev.varying[at(plan.bodies[b].varying)];
      add(body.mass, s.p + body.centre, s.v + cross(k.w, body.centre), k);
    }
  }
  return sum;
}

Balance calc_allowed_change(const PlanData& plan, const State& state, const Evaluation& ev) noexcept {
  Balance sum{{0, 0, 0}, {0, 0, 0}, 0};
  for (std::size_t j = 0; j < plan.joints.size(); ++j) {
    const JointFrame f = get_joint_frame(plan, state, ev, static_cast<int>(j));
    Vec3 impulse{0, 0, 0}, turn{0, 0, 0};
    for (int r = 0; r < kRows; ++r) {
      const double lambda = ev.multipliers[j * kRows + at(r)];
      if (lambda == 0) continue;
      sum.kinetic += 0.5 * lambda * (r < kRotX ? dot(column(f.n, r), f.v_rel) : dot(column(f.m, r - kRotX), f.w_rel));
      if (r < kRotX)
        impulse += lambda * column(f.n, r);
      else
        turn += lambda * column(f.m, r - kRotX);
    }
    if (plan.joints[j].base != kGround) continue;
    const Vec3 point = state.bodies[at(plan.joints[j].follower)].p + f.r_follower;
    sum.momentum += impulse;
    sum.angular_momentum += cross(point, impulse) + turn;
  }
  return sum;
}

}  // namespace unlatch
