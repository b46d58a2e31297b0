// Search for the first event within a sub-step (THEORY.md, sections 6 and 7).
//
// The sub-step is tried whole. Where guards cross zero in it, further tries locate the first crossing: at the zero of
// the chord, then of inverse parabolas, within a bracket that each try narrows; at its middle where these are not
// reliable (Brent, Algorithms for Minimization without Derivatives, 1973, chapter 4; here for the earliest zero of
// several functions). Pairs of shapes that touch and part again have guards below zero at both ends; their touch is
// searched at the peak between two flanks, as long as the tangents allow one. Each try is a new sub-step of full order
// from the same start, so that the state at an event is as accurate as any other.
//
// Symbols: a guard is a function that holds where it is ≥ 0; low and high are its values at the ends of the bracket,
// middle is that at the end which was replaced last (EventSearch). Formulas: kernel/events/crossing.h.
//
// Cost: one sub-step where nothing crosses; two or three more for a smooth guard; at most 24 tries, 8 more for touches.
#pragma once

#include "kernel/integration/integrator.h"
#include "kernel/integration/run.h"

namespace unlatch {

// Time that stands for a search which a vanished pivot ended; the report has the status.
inline constexpr double kFailed = -1;

// The end of a sub-step.
struct Reached {
  double time;    // s, or kFailed
  bool at_event;  // a guard has crossed zero there; tolerances of all guards are in EventSearch::tolerances
};

// Integrates from `now`, the time of the evaluation, to `target` or, if `may_split`, to the first event or the first
// corner of a law before it.
// Leaves the evaluation of that time, guards included; the state does not change. Without `may_split` crossings are
// counted as postponed. Adds to the report what the search left open.
Reached advance_to_event(Run& run, double now, double target, Contacts contacts, bool may_split) noexcept;

}  // namespace unlatch
