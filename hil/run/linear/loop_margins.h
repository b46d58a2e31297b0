// Stability and margins of a loop that flight software closes around one input of a linear model, with its sampling and
// its delay. Both are exact: no approximation of the delay, and the plant between samples as a held input moves it
// (Åström & Wittenmark, Computer-Controlled Systems, 3rd ed., 2.3).
//
// L is the open loop with the sign of negative feedback, at s = iω. A sampled loop is computed in δ = (z − 1)/T
// (Middleton & Goodwin, Digital Control and Estimation, 1990), which loses no digits where the period T is short: dx →
// δ x. A delay of whole periods and a fraction of one has two paths, one for the part of a period in which the older
// command is still held.
//
// The closed loop is stable if the argument of Π(δ − λ) (1 + L) grows by n π from ω = 0 to π/T, of a continuous one by
// n π/2 from 0 to ∞ (Mikhailov's criterion), λ the n poles of the plant: poles of the plant on the axis need no care.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/run/linear/linearization.h"

namespace unlatch::hil {

// A loop around one input: input = −Σ gain · output, sampled each `period` and held, `delay` late.
struct LoopRequest {
  std::string input;
  struct Term {
    double gain;
    std::string output;
  };
  std::vector<Term> terms;
  double period = 0;  // s, 0 or from 1e-9 on; 0: continuous
  double delay = 0;   // s, from the sample to the command; need not be a whole number of periods
};
// Parses "torque=12*sensor.angle+30*sensor.gyro.z". Throws LinearizationError.
LoopRequest parse_loop(const std::string& text);

// Margins of a loop, each the least over all crossings of frequencies from 0 to half the sampling frequency, both
// included; absent if the loop has no such crossing. Crossings at which |L| is below 1e-4 or above 1e4 are left out: a
// gain that may change ten thousand times.
struct LoopMargins {
  bool stable = false;  // the closed loop; of an unstable one the margins say how far it is from another state
  struct At {
    double value, frequency;  // frequency: rad/s; infinite of a crossing by what acts at once
  };
  std::optional<At> gain;   // factor above 1 that the loop's gain may grow by
  std::optional<At> drop;   // factor below 1 that it may fall to
  std::optional<At> phase;  // rad
  // s, beside the loop's own. Of a stable sampled loop the least that makes it unstable, absent beyond twice the phase
  // over its frequency; else by the phase.
  std::optional<At> delay;
};
// Throws LinearizationError: no such input or output; a period or a delay that is out of range, or so long beside the
// motion that the loop cannot be resolved.
LoopMargins calc_margins(const LinearSystem& system, const LoopRequest& loop);

}  // namespace unlatch::hil
