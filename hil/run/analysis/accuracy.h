// Accuracy of a run's numbers, from the same run at dt, dt/2 and dt/4.
//
// With a = |v(dt) − v(dt/2)| and b = |v(dt/2) − v(dt/4)| the observed order is p = log2(a/b). Richardson's rule gives
// the remaining error at dt/4 as b/(2^p − 1) (Roache, Verification and Validation in Computational Science, 1998). The
// reported error of v(dt) is |v(dt) − v(dt/4)| + b/(2^p − 1), with p kept within 0.5 and 4, plus rounding. For an order
// of two or more the first term alone is within a tenth of the error, and it is the error too where p is accidental.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/run/analysis/run_analysis.h"

namespace unlatch::hil {

// A number at the end of a run. Runs of one scenario at several steps have the same ones, identified by `what`.
struct NamedValue {
  enum class Kind { kTime, kClearance, kRate, kSeparation, kReaction, kContact, kPose, kRequirement };
  std::string what;  // "time of release booster1", "smallest clearance core – booster1", …
  std::string unit;
  Kind kind = Kind::kTime;
  double value = 0;
  double size = 0;  // scale of the error: the run's length, a distance moved, the largest reaction
  double time = 0;  // s: the instant of the value
};

// Lists event times, smallest clearances, rates at release, separations, peak reactions, contacts, final poses and
// values of requirements.
std::vector<NamedValue> list_values(const Scenario& scenario, const Simulation& simulation,
                                    const RunAnalysis& analysis);

struct AccuracyEntry {
  NamedValue value;              // value at dt
  double half = 0, quarter = 0;  // values at dt/2, dt/4
  double error = 0;              // error of `value`, in its unit
  std::optional<double> order;  // observed order; absent where only rounding is left, or the sequence does not converge
  bool settles = true;          // converges at the expected order, or to rounding
  std::string reason;           // likely reason, if it does not converge
  [[nodiscard]] double get_relative() const { return value.size > 0 ? error / value.size : 0; }
};

// Of one body's start the change that grows most, and the body that changes most by it at the end: in its place by
// places and velocities, in its attitude by attitudes and rates.
struct StartGrowth {
  enum class Of { kPlace, kVelocity, kAttitude, kRate };

  std::string start, end;  // bodies
  Of of = Of::kPlace;      // what is changed at the start
  // Change at the end over that of the start: of places m per m, of attitudes rad per rad; of velocities and rates,
  // over what they make in the time of the run without any force or torque. 1 in free motion, of a sphere's attitude.
  double factor = 0;
};
const char* get_name(StartGrowth::Of of);  // "place"

struct AccuracyReport {
  std::vector<AccuracyEntry> entries;
  std::string mismatch;  // difference other than in numbers: "an event more at dt/2: …"; or the failure of a run
  double tolerance = 0;  // relative to each value's size
  std::optional<double> step;       // s, the largest tried step that meets the tolerance; absent if none was found
  std::string limit;                // name of the value that limits the step
  bool interrupted = false;         // SIGINT or SIGTERM ended the comparison: entries may be missing
  std::vector<StartGrowth> growth;  // of changes of the start, where it is notable
  bool growth_measured = false;
  double growth_step = 0;      // s, step of the runs by which growth was measured
  bool out_of_budget = false;  // the search for the step ended before it had found one
};

// Distance over which the joint's forces make moments about the centres of its bodies: the larger of the two, m.
double calc_arm(const Joint& joint);

// Compares the values of three runs. Sets `mismatch` if their lists differ.
AccuracyReport compare_steps(const Scenario& scenario, const Simulation& simulation,
                             const std::vector<NamedValue>& full, const std::vector<NamedValue>& half,
                             const std::vector<NamedValue>& quarter);

// Step for a tolerance as the observed orders predict it, s, at most `most`, and the name of the value that limits it.
std::pair<double, std::string> estimate_step(const AccuracyReport& report, double dt, double tolerance, double most);

// Largest error of `values` relative to their scales, against the best values of `report`; infinite if the lists
// differ.
double calc_largest_error(const AccuracyReport& report, const std::vector<NamedValue>& values);

}  // namespace unlatch::hil
