// A sub-step of order eight: the explicit Runge-Kutta method with eleven stages of G. J. Cooper and J. H. Verner, "Some
// explicit Runge-Kutta methods of high order", SIAM J. Numer. Anal. 9, 1972. For blows and vibrations of contacts,
// whose forces are smooth between a touch, the change of a feature and a lift, at which sub-steps end: it errs less in
// parts of half of 1/ω than RK4 does in parts of an eighth of 1/ω.
//
// Cost beside RK4's: ten evaluations instead of three, the first stage being that of the beginning; the projection, the
// evaluation of the end and its guards are the same.
//
// Stack: 27 kB.
#pragma once

#include <array>

#include "kernel/elements/kinds/contact/contact_parts.h"

namespace unlatch {

// The stages of one try of h seconds; start and first rates are in the evaluation's blocks (begin_substep()).
class EighthOrderStages {
 public:
  static constexpr int kCount = 11;
  static constexpr int kMiddle = 8;  // the last stage in the middle of the sub-step
  static constexpr int kTimes = 7;   // of stages after the first whose time is not that of the one before
  // Time of a stage after the beginning, in h.
  static double get_time(int stage) noexcept;
  // The stage has the time of the one before it.
  static bool has_time_of_last(int stage) noexcept { return get_time(stage) == get_time(stage - 1); }

  EighthOrderStages(const PlanData& plan, double h, Evaluation& ev) noexcept : plan_(plan), h_(h), ev_(ev) {}
  // The first stage, which needs no evaluation: leaves the motion of the second.
  void begin() noexcept;
  // Another stage, of which `ev` is the evaluation: leaves the motion of the next, or of the end.
  void finish(int stage) noexcept;

 private:
  void move(std::size_t stage);

  const PlanData& plan_;
  const double h_;
  Evaluation& ev_;
  std::array<std::array<MotionT<double>, kMostImplicitBodies>, kCount> rates_;  // per stage
  std::array<std::array<double, kMostImplicitAuxiliary>, kCount> auxiliary_;    // the same of auxiliary states
};

}  // namespace unlatch
