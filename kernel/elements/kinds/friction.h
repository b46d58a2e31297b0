// Coulomb friction in joints, of the size of the reaction across the axis, see JointFriction in
// unlatch/model/elements.h.
//
// Force and reaction depend on each other: R = R_0 + R_1 F, F = −μ r |R| v / sqrt(v² + v_s²). An evaluation solves the
// system without friction, which gives R_0, and then kFrictionSweeps times with the friction of the latest R, all by
// one factorisation. So F depends on the instant alone: nothing is kept from stage to stage. Where friction moves no
// reaction (R_1 = 0) the first of these is exact; otherwise each takes the error times μ |R_1|, and what is left of |R|
// is (μ |R_1|)^kFrictionSweeps of the first change. μ |R_1| ≥ 1 is a joint that jams by itself: there rigid bodies with
// Coulomb's law have no answer (Painlevé), and the sweeps do not converge.
#pragma once

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/model/check.h"
#include "unlatch/readings.h"

namespace unlatch {

inline constexpr int kFrictionSweeps = 4;

// Some friction is switched on in a joint that holds.
bool has_friction(const Instant& now) noexcept;

// ev.friction_sizes, the force or torque on the follower along its axis: of no reaction, and of the present
// multipliers and speeds.
void clear_friction(Evaluation& ev) noexcept;
void update_friction(const Instant& now, Evaluation& ev) noexcept;

struct FrictionKind {
  static auto& of(auto& model) { return model.frictions; }
  static auto& of_plan(auto& plan) { return plan.frictions; }
  static constexpr bool kHasFriction = true;  // its size depends on a rate by Coulomb's law

  static void list_numbers(const JointFriction& f, const auto& add) {
    add(f.joint, f.axis, f.coefficient, f.radius, f.speed, f.on);
  }
  static void shift(JointFriction& f, const auto& by) { by.shift_joint(f.joint); }
  static bool reads_speed(const JointFriction& f) { return f.coefficient != 0; }
  static ElementTraits describe(const Model& model, const JointFriction& f) {
    ElementTraits traits = describe_in_joint("joint_friction", model, f.joint, f.axis);
    traits.note = "friction";
    return traits;
  }
  static void validate(const JointFriction& friction, const Check& check);
  static PlanFriction compile(const JointFriction& friction, ElementCompiler& compiler);
  static ElementStart start(const Model&, const JointFriction&) { return {}; }

  static bool acts(const Instant&, const Evaluation& ev, const PlanFriction&, std::size_t i) {
    return ev.friction_sizes[i] != 0;
  }
  // The size is that of the present sweep.
  static bool holds_ground(const PlanData& plan, const State&, const PlanFriction& own) {
    return plan.joints[at(own.joint)].base == kGround;
  }
  static Effort calc(const auto& motion, const PlanFriction& own, std::size_t i, double) {
    const std::size_t coordinate = at(own.coordinate);
    Effort effort = calc_in_joint(motion, motion.plan().coordinates[coordinate], motion.ev.coordinates[coordinate],
                                  motion.ev.speeds[coordinate]);
    effort.size = motion.ev.friction_sizes[i];
    return effort;
  }
  static ElementEnergy calc_energy(const StageMotion&, const PlanFriction&, const Effort& effort, double) {
    return {.dampers = effort.size * effort.rate};
  }
};

}  // namespace unlatch
