// Motion inside a step: the states and outputs between which it is smooth. A step is smooth from its beginning to the
// first instant at which events act, from there to the next, and to its end. Minima and event values that lie inside a
// step are read off these (hil/run/motion); the step itself needs none of it, and its bits do not depend on it. Where a
// law jumps, the piece before ends with the values that its stages approached, and the piece behind begins with the
// others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "unlatch/math.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"

namespace unlatch {

// The system at one end of a smooth piece of motion.
struct MotionKnot {
  double time = 0;      // s
  bool begins = false;  // a piece begins here: this is just after events, or the beginning of the step with its inputs
  // The pieces of motion that meet here are not one smooth curve, though the motion and its forces may be continuous: a
  // law that forces read, a table over time or a switch has a corner here, or has one that no step was split at on
  // either side.
  bool corner = false;
  bool reading_corner = false;  // likewise of a law that only conditions, sensors and outputs read: motion is smooth
  State state;                  // at `time`; its header has the tick at which the step began, but for the last knot
  std::span<Spatial> accelerations;  // of the bodies' origins, world axes, m/s², rad/s²; by body
  std::span<double> multipliers;     // six for each joint, N, N m
  std::span<double> sensors;         // as Workspace::sensors
  std::span<double> quantities;      // as Workspace::quantities
};

// The state between two rounds of events at one instant (THEORY.md, section 6): just after those of the step's events
// that are before number `fired`, just before the others.
struct RoundKnot {
  MotionKnot knot;        // the state, its time and what it is read as
  std::size_t fired = 0;  // events of the step that have acted by then
  // Events acted in the round before it, or velocities jumped; else pairs of shapes alone changed.
  bool decisive = false;
};

// Knots of one step, in memory that the caller owns: the beginning (begins); for each instant of events, and each other
// at which the step is split, the state just before and just after (begins); the end.
class MotionLog {
 public:
  MotionLog() = default;
  // `memory`: at least get_bytes(plan), aligned to 8. The plan must outlive it.
  MotionLog(const Plan& plan, std::span<std::byte> memory) noexcept;
  // Memory that the knots of one step take.
  static std::size_t get_bytes(const Plan& plan) noexcept;

  // Knots of the latest step; valid until the next.
  std::span<const MotionKnot> get_knots() const noexcept { return {knots_, count_}; }
  // The states behind the rounds of each instant, in their order; the last of an instant may be that of the knot just
  // after it. Rounds that change pairs of shapes alone share one.
  static constexpr std::size_t kMostRounds = 32;
  std::span<const RoundKnot> get_rounds() const noexcept { return {rounds_, round_count_}; }

  // For the step.
  void clear() noexcept { count_ = round_count_ = 0; }
  MotionKnot& add() noexcept;  // the next knot; the last one again where there are no more
  void remove() noexcept { count_ -= count_ > 0; }
  RoundKnot* add_round() noexcept;       // null where there are kMostRounds
  RoundKnot* get_last_round() noexcept;  // of those that there are
  // Marks the latest knot as a corner of the motion, of readings.
  void mark_corner() noexcept {
    if (count_ > 0) knots_[count_ - 1].corner = true;
  }
  void mark_reading_corner() noexcept {
    if (count_ > 0) knots_[count_ - 1].reading_corner = true;
  }

 private:
  MotionKnot* knots_ = nullptr;
  std::size_t count_ = 0, capacity_ = 0;
  RoundKnot* rounds_ = nullptr;
  std::size_t round_count_ = 0;
};

// The turn about axis k (0 to 2) by which the frame `follower` stands from the frame `base`, in (−π, π]: exact for a
// turn about that axis alone, and for both axes of a universal joint. Rad.
double calc_twist(const Mat3& base, const Mat3& follower, int k) noexcept;

}  // namespace unlatch
