// Corners of forces. Knots of linear tables over what moves, ends of smooth ones, and branches of min, max, abs and if,
// in laws that forces read; knots of the tables of pushers, stops and cords over their travel; rows of the wind and
// borders of the atmosphere's layers that a body in the air passes; knots of the masses of bodies that burn; and those
// whose time is known: points of loads' tables over time, ends of ramps, knots of masses over time.
// Runge and Kutta's method has its order only in sub-steps without them: event_search.cc splits a sub-step at the first
// of a law, of a travel, of the air or of what is burnt, step.cc at the first of the others.
//
// Cost: two bisections of an axis per corner and sub-step, likewise of a table over a travel or over time, of a mass
// and of the altitudes of the air's corners per aerodynamics, and a look at each switch; where a corner is passed, two
// or three more sub-steps, where its time is known one.
#pragma once

#include <span>

#include "kernel/events/limits.h"
#include "kernel/math/index.h"
#include "kernel/plan/evaluation.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/state.h"

namespace unlatch {

// Part of the step: corners that are nearer than this to an end of a sub-step are not inside it.
inline constexpr double kNearCorner = 1e-5;

// Which numbers of an evaluation have knots that are corners: law_places, altitudes, travels.
enum class CornerOf : std::int32_t { kLaw, kAir, kTravel };

struct PassedCorner {
  std::int32_t place = kNone;  // in these; kNone: none is passed
  CornerOf of = CornerOf::kLaw;
  double knot = 0;     // that is passed there
  bool jumps = false;  // the law's value may jump there
};

// Numbers whose knots are corners, as in Evaluation.
struct CornerPlaces {
  std::span<const double> laws, altitudes, travels;
  [[nodiscard]] double get(const PassedCorner& corner) const {
    const std::span<const double>& own =
        corner.of == CornerOf::kLaw ? laws : (corner.of == CornerOf::kAir ? altitudes : travels);
    return own[at(corner.place)];
  }
};
inline CornerPlaces get_corner_places(const Evaluation& ev) { return {ev.law_places, ev.altitudes, ev.travels}; }
inline CornerPlaces get_middle_places(const Evaluation& ev) {
  return {ev.middle_places, ev.middle_altitudes, ev.middle_travels};
}
// Those at the start of the sub-step.
inline CornerPlaces get_corner_places(const EventSearch& search) {
  return {search.places_low, search.altitudes_low, search.travels_low};
}

// The first corner that is passed in a sub-step from `begin` to `end`, by the chords between what the places have
// at both ends. Corners very near either end do not count: what they cost in accuracy is rounding. Jumps count up to
// the end, be it at the beginning. Those of an axis of which more than kMostCorners knots are passed do not count: a
// table that is finer than the step. `ended`: the corner just behind which the sub-step ends, which does not count
// again.
PassedCorner find_corner(const PlanData& plan, double begin, double end, const CornerPlaces& at_begin,
                         const CornerPlaces& at_end, const PassedCorner& ended = {}) noexcept;

// What the places are in a sub-step.
struct PassedPlaces {
  CornerPlaces at_begin, in_middle, at_end;
};
// True if the values in the middle show a corner that the chord between both ends does not: a law that goes and comes
// back, or comes back to where it began just before. What is over before the middle, or begins behind it, is not seen.
bool passes_and_returns(const PlanData& plan, double begin, double end, const PassedPlaces& places) noexcept;

// The time between `begin` and `end` of the first point of a load's table over time, of loads that act, of the first
// end of a ramp, and of the first knot of a mass over time; `end` if there is none. Tables with more than kMostCorners
// points in between do not count.
double find_time_corner(const PlanData& plan, const State& state, double begin, double end) noexcept;

struct PassedKnot {
  std::int32_t mass = kNone;  // of PlanData::varying; kNone: no knot is passed
  double burnt = 0;           // there, kg
  double part = 1;            // of the sub-step, by the chord
};
// The first knot of what a body has burnt that is passed in a sub-step from `begin` to `end`. Knots very near either
// end do not count, nor those of a body that passes more than kMostCorners. `at_begin`, `at_end`: of Auxiliary::now.
PassedKnot find_burnt_knot(const PlanData& plan, double begin, double end, std::span<const double> at_begin,
                           std::span<const double> at_end) noexcept;
// True if what a body has burnt is at one of its knots.
bool is_at_burnt_knot(const PlanData& plan, const Evaluation& ev) noexcept;

}  // namespace unlatch
