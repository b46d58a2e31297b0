// Touch, impulse and lift of rigid contacts at one instant, in the rounds of events (THEORY.md, section 7).
//
// Touch. All pairs that are closed take part: with the rates w⁻ of their gaps and the wanted w = −e w⁻ of those that
// touch, 0 of all others, the impulses p solve
//
//   w⁺ = w⁻ + Λ p,   w⁺ ≥ w,   p ≥ 0,   p (w⁺ − w) = 0,
//
// Λ being that of kernel/integration/rigid_rows.h: Newton's law for several touches at once (Moreau; Ch. Glocker,
// Set-Valued Force Laws, 2001). The kinetic energy changes by Σ p (w⁺ + w⁻)/2 = Σ p w⁻ (1 − e)/2 ≤ 0. Which of p are 0
// is decided by principal pivots, always of the least index (K. G. Murty, Opsearch 11, 1974), which ends wherever Λ is
// positive definite.
//
// Lift. Likewise of forces and accelerations, one pivot a round: a closed pair whose force pulls is opened, and one
// that was opened at this instant and would now overlap is closed again, the pair of the least number first.
#pragma once

#include "kernel/integration/run.h"

namespace unlatch {

// Forgets what pairs did at the instant before.
void begin_rigid_pairs(Run& run) noexcept;

// True if a pair that was opened at this instant would overlap now.
bool wants_rigid_pair(const Run& run) noexcept;

// Closes pairs that touch, opens those that leave or are off; if there are none, one whose force pulls is opened or one
// that would overlap is closed. Returns the number of changes, or kFailedTouch if a pair cannot be closed: its contact
// is Evaluation::rigid.failed.
// In late rounds all pairs change together.
inline constexpr int kFailedTouch = -1;
int change_rigid_pairs(Run& run, double now, std::size_t round, std::span<const double> tolerances) noexcept;

// True if an impulse is due: a pair has touched in this round, or some is closed while velocities `jumped`.
bool has_rigid_impulse(const Run& run, bool jumped) noexcept;

// Applies the impulse of all closed pairs. Adds to `allowed` the change that it may make. Returns kNone, or as
// kernel/integration/integrator.h says.
int strike_rigid_pairs(Run& run, double now, Balance& allowed) noexcept;

// Takes away what was left of slips that ended in this round: those whose directions were fixed end where they would
// go back, and what they have across these directions is below calc_least_slip(). The impulse is that of rows that
// close, with the kinetic energy that it takes. Returns likewise.
int stop_rigid_slips(Run& run, double now, Balance& allowed) noexcept;

}  // namespace unlatch
