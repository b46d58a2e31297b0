// Forces of the air on a body, by coefficients that are sums of numbers and laws; see Aerodynamics in
// unlatch/model/elements.h.
//
// A part that counts times a rate is multiplied by ¼ ρ V S l instead of q S l / (2 V), so that nothing is divided by
// the speed, and a body at rest in the air has no force.
#pragma once

#include <limits>

#include "kernel/elements/effort.h"
#include "kernel/elements/element_compiler.h"
#include "kernel/elements/energy_sum.h"
#include "kernel/elements/gravity.h"
#include "kernel/elements/push.h"
#include "kernel/environment/environment.h"
#include "kernel/model/check.h"
#include "unlatch/readings.h"

namespace unlatch {

// In body axes, the moment about the body's origin; N, N m. The altitude of its centre of mass, m.
struct AirForce {
  Vec3 force, moment;
  double altitude;
};

struct AerodynamicsKind {
  static auto& of(auto& model) { return model.aerodynamics; }
  static auto& of_plan(auto& plan) { return plan.aerodynamics; }

  static void list_numbers(const Aerodynamics& a, const auto& add) {
    add(a.body, a.area, a.lengths, a.point, a.on);
    for (const AeroTerm& term : a.terms) add(term.of, term.rate, term.value, term.law);
  }
  static void shift(Aerodynamics& a, const auto& by) {
    by.shift_body(a.body);
    for (AeroTerm& term : a.terms) by.shift_law(term.law);
  }
  static bool reads_speed(const Aerodynamics&) { return true; }
  static ElementTraits describe(const Model&, const Aerodynamics& a) {
    return {.kind = "aerodynamics", .follower = a.body, .has_coordinate = false};
  }
  static void validate(const Aerodynamics& a, const Check& check);
  static PlanAerodynamics compile(const Aerodynamics& a, ElementCompiler& compiler);
  static ElementStart start(const Model&, const Aerodynamics&) { return {}; }

  static bool acts(const Instant&, const Evaluation&, const PlanAerodynamics&, std::size_t) { return true; }
  static bool holds_ground(const PlanData&, const State&, const PlanAerodynamics&) { return false; }

  [[gnu::noinline]] static AirForce calc_force(const auto& motion, const PlanAerodynamics& own) {
    const PlanData& plan = motion.plan();
    const BodyFrame body = motion.get_frame(own.body);
    const PlanEnvironment& environment = plan.environment;
    const Flight flight = calc_flight(environment.planet, motion.time(), body.p, body.v);
    const AirFlow flow = calc_air_flow(environment.planet, get_air(plan), flight, body.R);
    const Vec3 spin = transpose_times(body.R, body.w - environment.planet.rate * environment.planet.axes.z);
    const Vec3 turning{spin.x * own.lengths.x, spin.y * own.lengths.y, spin.z * own.lengths.z};
    double still[kParts] = {}, turned[kParts] = {};  // sums of the parts without and with a rate
    for (std::int32_t i = own.first; i < own.first + own.count; ++i) {
      const PlanAeroTerm& term = plan.aero_terms[at(i)];
      const double value = term.law == kNone ? term.value : motion.ev.laws[at(term.law)];
      const int part = static_cast<int>(term.of);
      if (term.rate == kNone)
        still[part] += value;
      else
        turned[part] += value * (term.rate == 0 ? turning.x : (term.rate == 1 ? turning.y : turning.z));
    }
    const double drive = flow.dynamic_pressure * own.area, drag = 0.5 * flow.air.density * own.area;
    const double damp = 0.5 * drag * flow.speed;
    double sum[kParts - 1];
    for (int part = 0; part < kParts - 1; ++part) sum[part] = drive * still[part] + damp * turned[part];
    const double along = drag * (still[kDrag] * flow.speed + 0.5 * turned[kDrag]);
    const Vec3 force = Vec3{sum[0], sum[1], sum[2]} - along * flow.velocity;
    const Vec3 moment{own.lengths.x * sum[3], own.lengths.y * sum[4], own.lengths.z * sum[5]};
    return {force, moment + cross(own.point, force), flight.place.geodetic.altitude};
  }

  static void add_forces(const Instant& now, const PlanAerodynamics& own, double scale, Evaluation& ev) {
    const AirForce f = calc_force(StageMotion{now, ev}, own);
    if (!ev.altitudes.empty()) ev.altitudes[at(own.number)] = f.altitude;
    const Mat3 R = get_body_frame(ev, own.body).R;
    push(ev, own.body, scale * (R * f.force), scale * (R * f.moment));
  }
  // While it is off.
  static void rest(const PlanAerodynamics& own, Evaluation& ev) {
    if (!ev.altitudes.empty()) ev.altitudes[at(own.number)] = std::numeric_limits<double>::quiet_NaN();
  }
  static ElementReading read(const auto& motion, const PlanAerodynamics& own, std::size_t, double scale) {
    return {.force = scale == 0 ? 0 : scale * norm(calc_force(motion, own).force), .scale = scale};
  }
  static void add_energy(const StageMotion& motion, const PlanAerodynamics& own, std::size_t, EnergySum& sum) {
    const double scale = calc_scale(motion.state().elements[at(own.element)], motion.time());
    if (scale == 0) return;
    const AirForce f = calc_force(motion, own);
    const BodyFrame body = motion.get_frame(own.body);
    sum.push(PowerSource::kLoads, scale * (body.R * f.force), body.v);
    sum.add(PowerSource::kLoads, scale * dot(body.R * f.moment, body.w));
  }

 private:
  static constexpr int kParts = 7, kDrag = static_cast<int>(AeroTerm::Of::kDrag);
};

}  // namespace unlatch
