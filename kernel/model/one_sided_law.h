// The law of a one-sided force, see OneSided in unlatch/model/elements.h: force over travel, the energy that it stores,
// and what resists the motion. δ is the depth, u = stroke − δ the travel.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "kernel/math/table.h"
#include "unlatch/elementary.h"
#include "unlatch/model.h"

namespace unlatch {

// Numbers of a law, but for its table.
struct OneSidedNumbers {
  OneSided::Law kind;
  double stroke, preload, stiffness, gas_length, exponent;
  double damping, friction, friction_speed;
};
struct OneSidedLaw : OneSidedNumbers {
  std::span<const double> travels, forces;  // of a table
};

inline OneSidedLaw get_law(const OneSided& f) {
  return {{f.law, f.stroke, f.preload, f.stiffness, f.gas_length, f.exponent, f.damping, f.friction, f.friction_speed},
          f.travels,
          f.forces};
}

// (L / (L + u))^p
inline double calc_gas_ratio(const OneSidedLaw& law, double u, double power) {
  return elementary::exp(-power * elementary::log(1 + u / law.gas_length));
}

inline double calc_table_force(const OneSidedLaw& law, double u) {
  const std::span<const double> at = law.travels, force = law.forces;
  if (u <= at.front()) return force.front();
  if (u >= at.back()) return force.back();
  const std::size_t low = find_piece(at.size(), u, [&](std::size_t i) { return at[i]; }), high = low + 1;
  return force[low] + (force[high] - force[low]) * ((u - at[low]) / (at[high] - at[low]));
}

// F at the depth δ, N or N m.
inline double calc_elastic_force(const OneSidedLaw& law, double depth) {
  const double u = law.stroke - depth;
  switch (law.kind) {
    case OneSided::Law::kLinear:
      return law.preload - law.stiffness * u;
    case OneSided::Law::kTable:
      return calc_table_force(law, u);
    case OneSided::Law::kGas:
      return law.preload * calc_gas_ratio(law, u, law.exponent);
  }
  return 0;
}

// Largest |dF/du| over the stroke, N/m or N m/rad.
inline double calc_largest_stiffness(const OneSidedLaw& law) {
  if (law.kind == OneSided::Law::kLinear) return law.stiffness;
  if (law.kind == OneSided::Law::kGas) return law.exponent * law.preload / law.gas_length;
  double largest = 0;
  for (std::size_t i = 1; i < law.travels.size(); ++i)
    largest = std::max(largest, std::abs(law.forces[i] - law.forces[i - 1]) / (law.travels[i] - law.travels[i - 1]));
  return largest;
}

// ∫ F du of a table from u to its stroke's end: trapezoids, exact for straight pieces.
inline double calc_table_energy(const OneSidedLaw& law, double u) {
  const double end = law.stroke;
  double sum = 0, from = u, at_from = calc_table_force(law, u);
  const auto go = [&](double to) {
    const double force = calc_table_force(law, to);
    sum += 0.5 * (at_from + force) * (to - from);
    from = to;
    at_from = force;
  };
  for (const double knot : law.travels)
    if (knot > u && knot < end) go(knot);
  go(end);
  return sum;
}

// Stored energy, J: the work that it does from here to its limit without resistance.
inline double calc_stored_energy(const OneSidedLaw& law, double depth) {
  const double u = law.stroke - depth, end = law.stroke;
  switch (law.kind) {
    case OneSided::Law::kLinear:
      return (law.preload - law.stiffness * end) * depth + 0.5 * law.stiffness * depth * depth;
    case OneSided::Law::kTable:
      return calc_table_energy(law, u);
    case OneSided::Law::kGas: {
      const double work = law.preload * law.gas_length, p = law.exponent - 1;
      if (p == 0) return work * elementary::log((law.gas_length + end) / (law.gas_length + u));
      return work / p * (calc_gas_ratio(law, u, p) - calc_gas_ratio(law, end, p));
    }
  }
  return 0;
}

// The sum whose positive part is the force. Resistance acts against the motion: it lessens the force of a pusher, and
// adds to that of a stop that is hit.
inline double calc_sum(const OneSidedLaw& law, double depth, double depth_rate) {
  double sum = calc_elastic_force(law, depth) + law.damping * depth_rate;
  if (law.friction != 0)
    sum += law.friction * depth_rate / std::sqrt(depth_rate * depth_rate + law.friction_speed * law.friction_speed);
  return sum;
}

}  // namespace unlatch
