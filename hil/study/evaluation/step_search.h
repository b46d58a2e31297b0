// Search for the largest step at which all samples of a study meet a tolerance, from a few of them: corners of what may
// be drawn, and draws.
//
// The error at a step h is the difference from the same flight at half the given step (for steps below it at half of
// h), and as much again as the given step differs from that: a bound wherever halving a step at least halves the error.
// The largest over all flights must be within half the tolerance, which leaves room to samples that were not flown.
//
// Steps are whole multiples of the scenario's, and its halves, so that times on ticks stay there.
#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/study/evaluation/judged_values.h"

namespace unlatch::hil {

// A flight of the search: a corner or a draw.
struct StepFlight {
  std::string name;  // "corner 3", "sample 17"
  std::vector<Setting> settings;
};

struct StepTrial {
  double step = 0;     // s
  double error = 0;    // relative, of the worst flight
  bool met = false;    // it leaves room to samples that were not flown
  std::string of;      // its column
  std::string flight;  // its name
};

// What was found, and the evidence.
struct StepSearch {
  double tolerance = 0;        // relative
  double given = 0;            // s, the scenario's step
  std::optional<double> step;  // s; absent: none of the trials meets the tolerance
  std::vector<StepTrial> trials;
  std::size_t flights = 0;
};

// Setting of the step that reads as the same double. `step`: whole nanoseconds, s.
Setting make_step_setting(double step);
// Half of a step; nothing if that is no whole number of nanoseconds.
std::optional<double> halve_step(double step);

// `jobs`: threads; the result does not depend on them. Another thread may set `stop`: then `step` is absent.
StepSearch find_step(const SampleEvaluator& evaluator, const JudgedValues& judged, std::span<const StepFlight> flights,
                     double tolerance, int jobs, const std::atomic<bool>& stop);

// The largest step that two searches have both tried and found to meet the tolerance.
std::optional<double> find_common_step(const StepSearch& a, const StepSearch& b);

// Why no step was found, in a line.
std::string describe_failure(const StepSearch& search);

}  // namespace unlatch::hil
