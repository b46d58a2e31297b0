// The list of one run's results: the same columns for every sample of a scenario.
//
// clang-format off
//   ID                          value of a requirement, in its unit
//   ID.margin                   distance within the limit; < 0: not met
//   event.NAME:SUBJECT          s, first time
//   clearance.A.B               m, smallest of the run
//   clearance.A.B.t             s
//   clearance.A.B.released      m, smallest since the last joint between the two became free
//   tip_off.JOINT               rad/s, size of the follower's angular velocity when the joint first became free
//   separation.JOINT.along      m/s, of the follower's centre of mass along the separation axis at the end of push
//   separation.JOINT.across     m/s, across it
//   separation.JOINT.rate       rad/s, of the follower relative to the base, across the axis
//   peak.JOINT.ROW              N or N m, multiplier of the largest size, signed
//   ID.without_blow             s, of a requirement on a reaction: the first blow whose impulse its value leaves out
//   ID.uncertainty              in the requirement's unit, of one whose value may be off between steps: by how much at
//                               most, where that is more than a thousandth of it
//   contact.NAME.touch          s, first touch
//   contact.NAME.peak           N, largest normal force
//   contact.NAME.depth          m, largest depth
//   contact.NAME.impulse        N s, of the normal force
//   contact.NAME.dissipated     J
//   contact.NAME.duration       s, time closed
//   step                        s, of this sample; and
//   step.error                  its estimated error, relative: of a campaign with a tolerance (chosen_outputs.h)
//   output.…, curve.…           outputs that a campaign chooses (chosen_outputs.h)
// clang-format on
//
// NaN: the run has no such value, such as the time of an event that did not occur.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hil/run/analysis/run_analysis.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct ResultColumn {
  enum class Kind {
    kRequirement,
    kMargin,
    kEvent,
    kClearance,
    kClearanceTime,
    kReleased,
    kTipOff,
    kSeparation,
    kPeak,
    kContact,
    kOutput,
    kCurve,
    kStep,
    kStepError,
    kWithoutBlow,
    kUncertainty
  };
  Kind kind = Kind::kRequirement;
  std::string name, unit;  // SI
  std::size_t index = 0;   // index of the requirement, event, clearance, joint, contact, chosen value or curve
  // Separation: 0 along, 1 across, 2 rate; peak: the row; contact: the value, in the order above; curve: the point.
  std::size_t part = 0;
  bool operator==(const ResultColumn&) const = default;
};

// Columns of every run of the scenario, independent of its values.
std::vector<ResultColumn> list_columns(const Scenario& scenario);

// Parts of a run's analysis that these columns need.
AnalysisRequest list_needs(const std::vector<ResultColumn>& columns);

// Results of the run so far, one for each column.
std::vector<double> collect_results(const std::vector<ResultColumn>& columns, const Scenario& scenario,
                                    const RunAnalysis& analysis);

// Sentence that names what the steps of a run, or a requirement's extreme between them, did not resolve; or empty.
std::string describe_unresolved(const Scenario& scenario, const RunAnalysis& analysis);

// Full name of an event: "release:booster1", or the name alone.
std::string get_event_name(const Event& event);

}  // namespace unlatch::hil
