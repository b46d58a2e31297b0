// Springs between points, and one-sided forces, as a state has them, for reports. The step computes the same force by
// the same formula.
#pragma once

#include "unlatch/model.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Length and force of a spring between two points.
struct SpringReading {
  double length = 0;  // between its ends, m
  double force = 0;   // along the line on the follower, away from the base: a push is positive; N
  double scale = 0;   // of its switch: 0 while it is off
};

// Of a point spring (its number in the model) at the state's tick.
SpringReading calc_point_spring(const Plan& plan, const State& state, int spring) noexcept;

// Coordinate and force of a one-sided force.
struct OneSidedReading {
  double coordinate = 0;  // m or rad
  double depth = 0;       // to its limit, m or rad: negative beyond its reach
  double depth_rate = 0;  // m/s or rad/s
  double force = 0;       // N or N m, never negative; 0 while it is off or not engaged
  double scale = 0;       // of its switch: 0 while it is off
};

// Of the state that the latest step() or update_outputs() left in the workspace; its number among the model's one-sided
// forces.
OneSidedReading calc_one_sided(const Plan& plan, const State& state, const Workspace& workspace, int number) noexcept;

// The law of a one-sided force alone: its force while it is engaged, N or N m, and what it stores, J, at a depth and
// its rate, m and m/s or rad and rad/s.
double calc_one_sided_force(const OneSided& force, double depth, double depth_rate) noexcept;
double calc_one_sided_energy(const OneSided& force, double depth) noexcept;

// Coordinate of a one-sided force of the model at its initial poses, m or rad, and its limit. Markers are placed.
double calc_start(const Model& model, const OneSided& force);
double calc_limit(const Model& model, const OneSided& force);

}  // namespace unlatch
