// Torsion springs that keep an axis of one body in a plane of another, (4.17) with a signed angle.
#pragma once

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/model/check.h"
#include "unlatch/elementary.h"
#include "unlatch/readings.h"

namespace unlatch {

struct PlaneTorsionKind {
  static auto& of(auto& model) { return model.plane_torsions; }
  static auto& of_plan(auto& plan) { return plan.plane_torsions; }
  static constexpr bool kHasFriction = false;  // its size depends on a rate by Coulomb's law

  static void list_numbers(const PlaneTorsion& s, const auto& add) {
    add(s.base, s.follower, s.normal_base, s.axis_follower, s.stiffness, s.damping, s.on);
  }
  static void shift(PlaneTorsion& s, const auto& by) { by.shift_bodies(s.base, s.follower); }
  static bool reads_speed(const PlaneTorsion& s) { return s.damping != 0; }
  static ElementTraits describe(const Model&, const PlaneTorsion& s) {
    return {.kind = "plane_torsion", .base = s.base, .follower = s.follower, .note = "torsion", .angular = true};
  }
  static void validate(const PlaneTorsion& torsion, const Check& check);
  static PlanPlaneTorsion compile(const PlaneTorsion& torsion, ElementCompiler& compiler);
  static ElementStart start(const Model& model, const PlaneTorsion& torsion);

  static PlaneTorsionForce calc_force(const PlanPlaneTorsion& spring, const BodyFrame& base, const BodyFrame& follower,
                                      double scale) noexcept {
    PlaneTorsionForce f;
    const Vec3 normal = base.R * spring.normal_base, axis = follower.R * spring.axis_follower;
    const Vec3 across = cross(normal, axis);
    const double size = norm(across);
    f.angle = elementary::atan2(dot(normal, axis), size);
    if (size == 0) return f;
    f.axis = (1.0 / size) * across;
    f.rate = -dot(f.axis, follower.w - base.w);
    f.size = (spring.stiffness * f.angle + spring.damping * f.rate) * scale;
    f.acts = true;
    return f;
  }

  static bool acts(const Instant&, const Evaluation&, const PlanPlaneTorsion&, std::size_t) { return true; }
  static bool holds_ground(const PlanData&, const State&, const PlanPlaneTorsion& own) { return own.base == kGround; }
  static Effort calc(const auto& motion, const PlanPlaneTorsion& own, std::size_t, double scale) {
    const PlaneTorsionForce f = calc_force(own, motion.get_frame(own.base), motion.get_frame(own.follower), scale);
    return {.base = own.base,
            .follower = own.follower,
            .turns = true,
            .acts = f.acts,
            .direction = f.axis,
            .size = f.size,
            .length = f.angle,
            .rate = f.rate};
  }
  static ElementEnergy calc_energy(const StageMotion&, const PlanPlaneTorsion& own, const Effort& effort,
                                   double scale) {
    return {.potential = calc_stored(own.stiffness, effort.length),
            .dampers = -own.damping * scale * effort.rate * effort.rate};
  }
  static LinearSpring get_spring(const PlanData&, const PlanPlaneTorsion& own) { return {own.stiffness, own.damping}; }
};

}  // namespace unlatch
