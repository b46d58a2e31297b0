// Contacts as a state has them, for reports: force, depth and totals since the start; and distances of surfaces. The
// step computes the same by the same formulas. Off the step: some µs a call. World axes.
#pragma once

#include <span>

#include "unlatch/geometry.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Totals of a contact since the start, integrated with the motion; they stand in State::auxiliary.
struct ContactTotals {
  double impulse = 0;     // ∫ F_n dt, N s
  double slip = 0;        // path of the slip while it is closed, of several pairs weighted by their F_n, of such
                          // without force the plain mean, m
  double dissipated = 0;  // what damping and friction took, J
};
// Memory of the pairs of shapes of a contact.
std::span<const ContactState> get_contact_pairs(const Plan& plan, const State& state, int contact) noexcept;
// Totals of a contact (its number in the model) up to the state's tick.
ContactTotals get_contact_totals(const Plan& plan, const State& state, int contact) noexcept;

// A contact at one instant.
struct ContactReading {
  bool closed = false;   // some pair of its shapes is closed, and it is on
  double depth = 0;      // of its deepest pair, m; 0 while it is open
  double normal = 0;     // sum of F_n of its pairs, N
  double friction = 0;   // sum of |F_t| of its pairs, N
  double slip = 0;       // |v_t| of its pairs, weighted by their F_n, m/s
  Vec3 force{0, 0, 0};   // on the follower, N
  Vec3 point{0, 0, 0};   // where it acts, of several pairs the mean weighted by F_n, m
  double stiffness = 0;  // sum of dF_n/dδ of its pairs without damping, N/m
};
// Reading of a contact (its number in the model) at the state's tick.
ContactReading calc_contact(const Plan& plan, const State& state, int contact) noexcept;

// Gives a state the forces of its rigid contacts, where the workspace has its outputs: after init_state() and
// update_outputs(). Steps do that by themselves.
void store_rigid_forces(const Plan& plan, const Workspace& workspace, State& state) noexcept;

// Distance of two surfaces (their numbers in the model) at the state's poses, m: signed, with witnesses and normal.
geometry::GroupDistance calc_shape_distance(const Plan& plan, const State& state, int a, int b) noexcept;

}  // namespace unlatch
