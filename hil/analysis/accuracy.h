// How far a run's numbers can be trusted: the same run at dt, dt/2 and dt/4.
//
// With a = |v(dt) − v(dt/2)| and b = |v(dt/2) − v(dt/4)| the observed order is p = log2(a/b), and Richardson's rule
// gives what is still missing at dt/4 as b/(2^p − 1) (Roache, Verification and Validation in Computational Science,
// 1998). The error of v(dt) is told as |v(dt) − v(dt/4)| + b/(2^p − 1), p kept within 0.5 and 4, plus rounding: for an
// order of two or more the first term alone is within a tenth of the error, and it is the error too where p is a matter
// of chance.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/analysis/run_analysis.h"

namespace unlatch::hil {

// A number that a run ends with. Runs of one scenario at several steps have the same ones, by `what`.
struct NamedValue {
  enum class Kind { kTime, kClearance, kRate, kSeparation, kReaction, kContact, kPose, kRequirement };
  std::string what;  // "time of release booster1", "smallest clearance core – booster1", …
  std::string unit;
  Kind kind = Kind::kTime;
  double value = 0;
  double size = 0;  // what an error is compared with: the run's length, a distance moved, a reaction's largest
  double time = 0;  // s: the instant that it is of
};

// Event times, smallest clearances, rates at release, separations, peak reactions, contacts, final
// poses, values of requirements.
std::vector<NamedValue> list_values(const Scenario& scenario, const Simulation& simulation,
                                    const RunAnalysis& analysis);

struct AccuracyEntry {
  NamedValue value;              // at dt
  double half = 0, quarter = 0;  // at dt/2, dt/4
  double error = 0;              // of value, in its unit
  std::optional<double> order;   // observed; absent where rounding is all that is left, or the sequence does not settle
  bool settles = true;           // at the expected order, or to rounding
  std::string reason;            // likely, if it does not settle
  [[nodiscard]] double get_relative() const { return value.size > 0 ? error / value.size : 0; }
};

struct AccuracyReport {
  std::vector<AccuracyEntry> entries;
  std::string mismatch;        // the runs differ in more than numbers: "an event more at dt/2: …"; or one failed
  double tolerance = 0;        // relative to each value's size
  std::optional<double> step;  // s, the largest that meets it, tried; absent if none was found
  std::string limit;           // the value that limits it
};

// Of three runs' values. `mismatch` if their lists differ.
AccuracyReport compare_steps(const Scenario& scenario, const Simulation& simulation,
                             const std::vector<NamedValue>& full, const std::vector<NamedValue>& half,
                             const std::vector<NamedValue>& quarter);

// The step for a tolerance as the observed orders have it, s, at most `most`, and the value that limits it.
std::pair<double, std::string> estimate_step(const AccuracyReport& report, double dt, double tolerance, double most);

// The largest error of `values`, relative to sizes, beside the best values of `report`; infinite if the lists differ.
double calc_largest_error(const AccuracyReport& report, const std::vector<NamedValue>& values);

}  // namespace unlatch::hil
