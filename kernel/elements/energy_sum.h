// EnergySum: energies and powers of a system that are being added up, see unlatch/energy.h.
#pragma once

#include "kernel/plan/plan_data.h"
#include "unlatch/energy.h"
#include "unlatch/state.h"

namespace unlatch {

// The sum for an observer with the velocity `frame`, W, m/s.
struct EnergySum {
  EnergyFlow flow{};
  Vec3 frame;

  // Adds the power of a force, N, on a point that moves with v, m/s; both in world axes.
  void push(PowerSource source, const Vec3& force, const Vec3& v) {
    flow.power[at(static_cast<int>(source))] += dot(force, v - frame);
    flow.force[at(static_cast<int>(source))] += force;
  }
  // Adds a power of internal forces, W: the same for every observer.
  void add(PowerSource source, double power) { flow.power[at(static_cast<int>(source))] += power; }

  void add_body(double mass, const Vec3& v, double spin_energy) {
    const Vec3 seen = v - frame;
    flow.mass += mass;
    flow.momentum += mass * seen;
    flow.kinetic += 0.5 * mass * dot(seen, seen) + spin_energy;
  }

  // Adds a potential, J, times the element's switch scale; while the scale ramps, the switch has a power.
  void store(const ElementState& element, double t, double potential) {
    const double elapsed = t - element.start;
    const double rate = elapsed >= 0 && elapsed < element.duration ? (element.to - element.from) / element.duration : 0;
    flow.strain += calc_scale(element, t) * potential;
    add(PowerSource::kSwitching, rate * potential);
  }
};

}  // namespace unlatch
