// Results of a run for engineers, gathered step by step off the cyclic thread: the event timeline, clearances,
// separations, peak reactions, audits, and the verdict on the requirements. A run in the loop is analysed by replaying
// it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/analysis/analysis_request.h"
#include "hil/analysis/peak_reactions.h"
#include "hil/analysis/requirements.h"
#include "hil/motion/clearance_history.h"
#include "hil/motion/contact_history.h"
#include "hil/motion/motion_window.h"
#include "hil/notices/notices.h"
#include "hil/scenario/scenario.h"
#include "hil/separations/separations.h"
#include "hil/simulation/simulation.h"
#include "unlatch/redundancy.h"

namespace unlatch::hil {

struct TimelineEntry {
  double time = 0;  // s
  std::string name, subject;
};

// A body let go: its state at the instant at which a joint to it became free.
struct TipOff {
  double time = 0;
  std::string body, base, joint;  // base: what it was joined to
  Vec3 w{};                       // body axes, rad/s
};

// Reactions that were not unique, from one time to another: rows of their joints were redundant.
struct SharedReactions {
  RedundantRows rows;
  double from = 0, until = 0;  // s
  bool lasts = false;          // at the latest state
};

// What the steps' searches for events left open because a bound on their work was reached.
struct SearchTotals {
  std::int64_t postponed = 0;  // instants of events left to a later tick
  std::int64_t unlocated = 0;  // instants of events known worse than to the tolerance of the search
  std::int64_t unseen = 0;     // times that shapes may have touched and parted within a step
};

class RunAnalysis {
 public:
  // The simulation keeps its motion from now on.
  RunAnalysis(const Scenario& scenario, Simulation& simulation, const AnalysisRequest& request = {});

  // Looks at the state as it is, and at what its last step reported (a default report for the initial state).
  void update(const StepReport& report);

  std::vector<TimelineEntry> timeline;
  std::vector<TipOff> tip_offs;
  std::vector<EventAudit> audits;
  std::vector<SharedReactions> shared;  // in the order in which they began
  // Located inside the steps.
  [[nodiscard]] PeakReaction get_peak(std::size_t joint, std::size_t row) const { return peaks_.get(joint, row); }
  const std::vector<Clearance>& clearances() const { return clearance_.get(); }
  // Witnesses and nearest shapes of clearance number `pair` when it was smallest.
  [[nodiscard]] PairDistance calc_witnesses(int pair) const { return clearance_.calc_witnesses(pair); }
  // Of the run so far.
  [[nodiscard]] std::vector<Verdict> judge() const { return requirements_.judge(window_); }
  [[nodiscard]] std::vector<Separation> list_separations() const { return separations_.list(clearance_); }
  [[nodiscard]] std::vector<ContactRecord> list_contacts() const { return contacts_.list(); }
  // The present value of requirement number i, see RequirementMonitor::get_now().
  [[nodiscard]] double get_requirement_now(std::size_t i) const { return requirements_.get_now(i); }
  const AccuracyWatch& accuracy() const { return accuracy_.value(); }  // notices, energy; if they were asked for
  SearchTotals search;

 private:
  void add_motion(std::span<const FiredEvent> events);
  void add_event(const FiredEvent& fired, const MotionKnot& after);
  void update_shared(const StepReport& report);

  const Scenario& scenario_;
  const Simulation& simulation_;
  const AnalysisRequest request_;
  std::optional<std::int32_t> redundant_;  // rows, at the latest state
  MotionWindow window_;
  ClearanceHistory clearance_;
  ContactHistory contacts_;
  PeakReactions peaks_;
  RequirementMonitor requirements_;
  SeparationMonitor separations_;
  std::optional<AccuracyWatch> accuracy_;
};

// The tick nearest to a time.
std::int64_t calc_nearest_tick(double time, double dt);

}  // namespace unlatch::hil
