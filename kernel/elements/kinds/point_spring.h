// Springs between points of two bodies, and pushers that stay on at their free length, (4.12) to (4.14).
#pragma once

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/model/check.h"
#include "unlatch/readings.h"

namespace unlatch {

struct PointSpringKind {
  static auto& of(auto& model) { return model.point_springs; }
  static auto& of_plan(auto& plan) { return plan.point_springs; }
  static constexpr bool kHasFriction = false;  // its size depends on a rate by Coulomb's law

  static void list_numbers(const PointSpring& s, const auto& add) {
    add(s.base, s.follower, s.point_base, s.point_follower, s.stiffness, s.damping, s.free_length, s.push_only, s.on);
  }
  static void shift(PointSpring& s, const auto& by) { by.shift_bodies(s.base, s.follower); }
  static bool reads_speed(const PointSpring& s) { return s.damping != 0; }
  static ElementTraits describe(const Model&, const PointSpring& s) {
    return {.kind = "spring",
            .base = s.base,
            .follower = s.follower,
            .note = s.push_only ? "pushes" : "",
            .has_points = true,
            .has_stroke = true};
  }
  static void validate(const PointSpring& spring, const Check& check);
  static PlanPointSpring compile(const PointSpring& spring, ElementCompiler& compiler);
  static ElementStart start(const Model& model, const PointSpring& spring);

  static PointSpringForce calc_force(const PlanPointSpring& spring, const BodyFrame& base, const BodyFrame& follower,
                                     double scale) noexcept {
    PointSpringForce f{base.R * spring.point_base, follower.R * spring.point_follower};
    const PointLine line = calc_line((follower.p + f.r_follower) - (base.p + f.r_base));
    f.length = line.length;
    if (f.length == 0) return f;
    f.direction = line.direction;
    if (spring.push_only && f.length >= spring.free_length) return f;
    f.rate = dot(f.direction, (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base)));
    f.size = -(spring.stiffness * (f.length - spring.free_length) + spring.damping * f.rate) * scale;
    f.elastic = -spring.stiffness * (f.length - spring.free_length) * scale;
    f.viscous = -spring.damping * f.rate * scale;
    if (spring.push_only && f.size < 0) {
      f.size = 0;
      f.viscous = -f.elastic;
    }
    f.acts = true;
    return f;
  }

  static bool acts(const Instant&, const Evaluation&, const PlanPointSpring&, std::size_t) { return true; }
  static bool holds_ground(const PlanData&, const State&, const PlanPointSpring& own) { return own.base == kGround; }
  static Effort calc(const auto& motion, const PlanPointSpring& own, std::size_t, double scale) {
    const PointSpringForce f = calc_force(own, motion.get_frame(own.base), motion.get_frame(own.follower), scale);
    return {.base = own.base,
            .follower = own.follower,
            .acts = f.acts,
            .direction = f.direction,
            .r_base = f.r_base,
            .r_follower = f.r_follower,
            .size = f.size,
            .length = f.length,
            .rate = f.rate,
            .stroke = own.free_length - f.length};
  }
  static ElementEnergy calc_energy(const StageMotion&, const PlanPointSpring& own, const Effort& effort, double scale) {
    const double stretch = effort.length - own.free_length;
    if (own.push_only && stretch >= 0) return {};
    const double elastic = -own.stiffness * stretch * scale;
    return {.potential = calc_stored(own.stiffness, stretch), .dampers = (effort.size - elastic) * effort.rate};
  }
  static LinearSpring get_spring(const PlanData&, const PlanPointSpring& own) { return {own.stiffness, own.damping}; }
};

}  // namespace unlatch
