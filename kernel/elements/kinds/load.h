// Loads: forces and torques that a profile over time and a command size. They do not depend on the motion, so that the
// stages at one instant share their sizes; those fixed in a body are summed in its axes, and turned with it. Loads that
// a law sizes (kernel/laws) may depend on the motion, and are computed in every stage.
#pragma once

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/elements/energy_sum.h"
#include "kernel/model/check.h"
#include "unlatch/readings.h"

namespace unlatch {

// A profile's value, s seconds after its element was switched on.
double calc_profile(const PlanData& plan, const PlanProfile& profile, double s) noexcept;

// ev.load_sizes, and in the blocks the wrenches that loads fixed in a body add up to.
void update_loads(const Instant& now, Evaluation& ev) noexcept;
// Sizes of loads that laws size. `laws`: the model's; `load_sizes`: Evaluation::load_sizes.
void update_law_loads(const Instant& now, std::span<const double> laws, std::span<double> load_sizes) noexcept;

struct LoadKind {
  static auto& of(auto& model) { return model.loads; }
  static auto& of_plan(auto& plan) { return plan.loads; }

  static void list_numbers(const Load& l, const auto& add) {
    add(l.body, l.kind, l.frame, l.point, l.direction, l.profile, l.channel, l.on);
    if (l.consumption != 0) add(l.consumption, l.tank);
  }
  static void shift(Load& l, const auto& by) {
    by.shift_body(l.body);
    by.shift_body(l.tank);
    by.shift_channel(l.channel);
    by.shift_law(l.profile.law);
  }
  static bool reads_speed(const Load&) { return false; }
  static ElementTraits describe(const Model&, const Load& l) {
    return {.kind = l.kind == Load::Kind::kTorque ? "torque" : "force",
            .follower = l.body,
            .angular = l.kind == Load::Kind::kTorque,
            .has_coordinate = false};
  }
  static void validate(const Load& load, const Check& check);
  static PlanLoad compile(const Load& load, ElementCompiler& compiler);
  static ElementStart start(const Model&, const Load&) { return {}; }

  static bool holds_ground(const PlanData&, const State&, const PlanLoad&) { return false; }
  static ElementReading read(const auto& motion, const PlanLoad& own, std::size_t i, double scale) {
    return {.force = motion.ev.load_sizes[i] * own.length, .scale = scale};
  }
  static void add_energy(const StageMotion& motion, const PlanLoad& own, std::size_t i, EnergySum& sum);
};

}  // namespace unlatch
