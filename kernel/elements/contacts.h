// Compliant contacts: forces of pairs of shapes that are closed. K. H. Hunt and F. R. E. Crossley, "Coefficient of
// restitution interpreted as damping in vibroimpact", 1975; regularised Coulomb friction. THEORY.md has the law.
//
// A pair that is open at the beginning of a sub-step has no force within it: the sub-step ends where it touches
// (kernel/step), so that stages see a smooth force. Cost: one distance per closed pair and stage.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/joints/kinematics.h"
#include "unlatch/contacts.h"

namespace unlatch {

// A pair of shapes at one instant; forces at the contact's switch scale.
struct PairForce {
  Vec3 point{0, 0, 0};              // midpoint of the witnesses, W, m
  Vec3 force{0, 0, 0};              // on the follower, at `point`, N
  double depth = 0, rate = 0;       // δ, m; dδ/dt, m/s
  double normal = 0, friction = 0;  // F_n and |F_t|, N
  Vec3 slip_velocity{0, 0, 0};      // v_t, W, m/s
  double slip = 0;                  // |v_t|, m/s
  double elastic = 0, stored = 0;   // k δⁿ, N; k δⁿ⁺¹/(n + 1), J
  double stiffness = 0;             // n k δⁿ⁻¹, N/m
  double calc_loss() const { return (normal - elastic) * rate + friction * slip; }  // W
};
PairForce calc_pair_force(const PlanContact& contact, const geometry::Distance& distance, const BodyFrame& base,
                          const BodyFrame& follower, double scale) noexcept;

// Adds the forces of closed pairs, and the rates of the contacts' totals; ev.pair_distances of those pairs. Needs the
// bodies' kinematics.
void add_contacts(const Instant& now, Evaluation& ev) noexcept;

// k δⁿ⁺¹/(n + 1) at scale 1, J.
double calc_stored(const PlanContact& contact, double depth) noexcept;

// Signed distance of two surfaces where a guard could cross `threshold` within a step; farther apart a lower bound,
// which is above `threshold`. Needs the bodies' kinematics.
double calc_guarded_distance(const PlanData& plan, const Evaluation& ev, int a, int b, double threshold) noexcept;

// ev.pair_distances and ev.pair_rates of pairs that are open and on: distances and their rates, or lower bounds of
// those that cannot touch within a step and 0.
void update_open_pairs(const Instant& now, Evaluation& ev) noexcept;

// A contact at any instant of a step. Needs the bodies' kinematics.
ContactReading calc_contact(const Instant& now, const Evaluation& ev, int contact) noexcept;

// Distance of two surfaces. Needs the bodies' kinematics.
double calc_shape_distance(const PlanData& plan, const Evaluation& ev, int a, int b) noexcept;

}  // namespace unlatch
