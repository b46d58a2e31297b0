// Signature of a kind's calculation, and the motion that the families read. The motion is the evaluation's, never the
// state's: in stages and tries the state is still that of the beginning of the sub-step.
#pragma once

#include "kernel/elements/instant.h"
#include "kernel/joints/kinematics.h"

namespace unlatch {

inline constexpr int kMostValues = 6;  // of one quantity

// Writes the values of a kind, count_values() of them. `ev`: the whole evaluation of this instant.
//
using QuantityCalc = void (*)(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out);

inline void put(double* out, const Vec3& a) {
  out[0] = a.x;
  out[1] = a.y;
  out[2] = a.z;
}

}  // namespace unlatch
