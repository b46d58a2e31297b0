// Friction of rigid contacts at one instant: its impulses, and the changes between sticking and slipping.
//
// Impulse. With the rates w of the gaps and the slips u of all closed pairs, Λ over both, Newton's law along the
// normals (rigid_pairs.h) and Coulomb's across them,
//
//   |p_t| ≤ μ p_n,   u⁺ = 0 or p_t = −μ p_n u⁺/|u⁺|,
//
// are solved together, pair by pair in their order until nothing changes (projected Gauss and Seidel; J. J. Moreau,
// "Unilateral contact and dry friction in finite freedom dynamics", 1988), each pair exactly, given the impulses of the
// others; where that does not end, by Newton's method (kernel/events/cone_impulses.h). Without restitution the kinetic
// energy changes by −½ pᵀΛp − μ p_n|u⁺|, and never grows. With it, friction that is coupled to the normals may add
// energy (T. R. Kane, 1984): then all coefficients of restitution of the blow are lessened by the least common factor
// with which it does not grow.
//
// Modes. A pair sticks as long as |T| ≤ μ N. A slip that begins, against T, has that direction until it is fast enough
// to have one of its own (calc_least_slip()); it ends where it would reverse.
#pragma once

#include "kernel/integration/run.h"

namespace unlatch {

// The impulses of ev.rigid.rows, in ev.rigid.forces. `restitutions`: per row, 0 where it does not bounce. False if they
// are not found; the contact is ev.rigid.failed.
bool find_friction_impulses(const PlanData& plan, std::span<const double> restitutions, Evaluation& ev) noexcept;

// True if a slip that begins would go back: its pair sticks.
bool would_stick(const Run& run, std::size_t pair, double largest_force) noexcept;
// True if a closed pair with friction has yet to be found sticking or slipping.
bool is_undecided(const Run& run, std::size_t pair) noexcept;
// True if a slip that begins at this instant begins in another direction than its friction has: that of its
// acceleration.
bool would_turn(const Run& run, std::size_t pair, Vec3& direction) noexcept;
void turn_slip(Run& run, std::size_t pair, const Vec3& direction) noexcept;
// True if the friction of a held pair is about to begin or to end holding it. If it is not where the pair's guard
// crosses zero, and its force is not about to fall to zero, then the force jumps: a corner of a shape has passed, and
// the pair opens.
bool is_friction_changing(const Run& run, std::size_t pair) noexcept;
// The next mode of a pair whose friction begins or ends to hold it; where a slip ends, others that have all but ended
// do as well. True if that slip was not located, so that some of it is left.
bool change_friction(Run& run, std::size_t pair) noexcept;
// Where the changes of one pair after the other do not end: pairs whose slip is all but zero stick; and then, in an
// evaluation of these, all pairs get the modes of the forces that cone_impulses.h finds, those that leave kPairLeaves.
// False if none are found.
void rest_slow_pairs(Run& run) noexcept;
bool find_friction_modes(Run& run) noexcept;
// The mode of a pair after an impulse. `first`, `second`: its slip after it along ev.rigid.rows, m/s; `rest`: what
// counts for none.
void set_friction(Run& run, int row, double first, double second, double rest) noexcept;

// The beginning of a sub-step: directions of slips are those of now. False if the evaluation failed.
bool begin_slips(Run& run, double now) noexcept;

}  // namespace unlatch
