// Springs, dampers and motors along or about an axis of a joint. Stiff ones are integrated implicitly: compliance.h.
#pragma once

#include "kernel/elements/compliance.h"
#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/model/check.h"
#include "unlatch/readings.h"

namespace unlatch {

struct JointSpringKind {
  static auto& of(auto& model) { return model.joint_springs; }
  static auto& of_plan(auto& plan) { return plan.joint_springs; }
  static constexpr bool kHasFriction = false;  // its size depends on a rate by Coulomb's law

  static void list_numbers(const JointSpring& s, const auto& add) {
    add(s.joint, s.axis, s.effort, s.stiffness, s.damping, s.rest, s.on);
    if (s.implicit) add(*s.implicit);
  }
  static void shift(JointSpring& s, const auto& by) { by.shift_joint(s.joint); }
  static bool reads_speed(const JointSpring& s) { return s.damping != 0; }
  static ElementTraits describe(const Model& model, const JointSpring& s) {
    return describe_in_joint("joint_spring", model, s.joint, s.axis);
  }
  static void validate(const JointSpring& spring, const Check& check);
  static PlanJointSpring compile(const JointSpring& spring, ElementCompiler& compiler);
  static ElementStart start(const Model& model, const JointSpring& spring);

  static bool acts(const Instant&, const Evaluation&, const PlanJointSpring&, std::size_t) { return true; }
  static bool holds_ground(const PlanData& plan, const State&, const PlanJointSpring& own) {
    return plan.joints[at(own.joint)].base == kGround;
  }
  static Effort calc(const auto& motion, const PlanJointSpring& own, std::size_t, double scale) {
    const std::size_t coordinate = at(own.coordinate);
    double x = motion.ev.coordinates[coordinate], rate = motion.ev.speeds[coordinate], lead = 0;
    if (own.compliant != kNone) lead = calc_lead(motion.ev.compliant[at(own.compliant)], motion.implicit(), x, rate);
    Effort effort = calc_in_joint(motion, motion.plan().coordinates[coordinate], x, rate);
    effort.size = calc_joint_spring(own, x, rate, scale) + lead;
    return effort;
  }
  static ElementEnergy calc_energy(const StageMotion&, const PlanJointSpring& own, const Effort& effort, double scale) {
    return {.potential = calc_stored(own.stiffness, effort.length - own.rest),
            .motors = own.effort * scale * effort.rate,
            .dampers = -own.damping * scale * effort.rate * effort.rate};
  }
  static LinearSpring get_spring(const PlanData&, const PlanJointSpring& own) {
    return {own.stiffness, own.damping, own.compliant != kNone};
  }
};

}  // namespace unlatch
