// Results of a run for engineers, gathered step by step off the cyclic thread: the event timeline, clearances,
// separations, peak reactions, audits, and the verdict on the requirements. A run in the loop is analysed by replaying
// it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/run/analysis/analysis_request.h"
#include "hil/run/analysis/peak_reactions.h"
#include "hil/run/analysis/requirements.h"
#include "hil/run/analysis/separations.h"
#include "hil/run/audit/unseen_crossings.h"
#include "hil/run/audit/unseen_engagements.h"
#include "hil/run/motion/clearance_history.h"
#include "hil/run/motion/contact_history.h"
#include "hil/run/motion/motion_window.h"
#include "hil/run/motion/unseen_clearances.h"
#include "hil/run/notices/notices.h"
#include "hil/run/recording/log_format.h"
#include "hil/run/simulation/simulation.h"
#include "hil/scenario/scenario.h"
#include "unlatch/redundancy.h"

namespace unlatch::hil {

struct TimelineEntry {
  double time = 0;  // s
  std::string name, subject;
  std::string shapes = {};  // of the touch or lift of a contact: the pairs of shapes that close or open
  int event = kNone;        // of the model
  double rate = 0;  // at which the quantity that it waits for passed its threshold, in its unit per s; 0: unknown
  static constexpr double kKnown = 1e-6;  // s: less is no uncertainty worth a word
};

// Release of a body: its state at the instant at which a joint to it became free.
struct TipOff {
  double time = 0;
  std::string body, base, joint;  // base: the body at the other side of the joint
  Vec3 w{};                       // angular velocity, body axes, rad/s
};

// Reactions that were not unique during an interval: rows of their joints were redundant.
struct SharedReactions {
  RedundantRows rows;
  double from = 0, until = 0;  // s
  bool lasts = false;          // still redundant at the latest state
};

// Events that the searches within steps left open because they reached a bound on their work.
struct SearchTotals {
  std::int64_t postponed = 0;  // instants of events that were left to a later tick
  std::int64_t unlocated = 0;  // instants of events that are less accurate than the tolerance of the search
  std::int64_t corners = 0;    // corners of laws at which a step was not split
  std::int64_t unseen = 0;     // cases in which shapes may have touched and separated within a step
};

class RunAnalysis {
 public:
  // Makes the simulation keep its motion from now on.
  RunAnalysis(const Scenario& scenario, Simulation& simulation, const AnalysisRequest& request = {});

  // Analyses the present state and the report of its step (a default report for the initial state). `received`: values
  // of sensors that flight software had otherwise than as sampled.
  void update(const StepReport& report, std::span<const LogReceived> received = {});

  std::vector<TimelineEntry> timeline;
  std::vector<TipOff> tip_offs;
  std::vector<EventAudit> audits;
  std::vector<SharedReactions> shared;  // in the order of their beginning
  // Peaks are located inside the steps.
  [[nodiscard]] PeakReaction get_peak(std::size_t joint, std::size_t row) const { return peaks_.get(joint, row); }
  const std::vector<Clearance>& clearances() const { return clearance_.get(); }
  // Witness points and nearest shapes of clearance number `pair` at its smallest value.
  [[nodiscard]] PairDistance calc_witnesses(int pair) const { return clearance_.calc_witnesses(pair); }
  // Verdicts on the run so far; those that depend on something that the step did not resolve are unresolved.
  [[nodiscard]] std::vector<Verdict> judge() const;
  [[nodiscard]] std::vector<Separation> list_separations() const { return separations_.list(clearance_); }
  [[nodiscard]] std::vector<ContactRecord> list_contacts() const { return contacts_.list(); }
  // Present value of requirement number i, see RequirementMonitor::get_now().
  [[nodiscard]] double get_requirement_now(std::size_t i) const { return requirements_.get_now(i); }
  // How far the time of an event may be wrong by the errors of the steps, s: those of the quantity that it waits for,
  // over its rate there. 0 where it waits for anything else.
  [[nodiscard]] double calc_time_uncertainty(const TimelineEntry& entry) const;
  const NoticeWatch& accuracy() const { return accuracy_; }  // notices; energy only if requested
  SearchTotals search;

 private:
  void add_received(std::span<const LogReceived> received);
  void add_motion(std::span<const FiredEvent> events);
  [[nodiscard]] std::string list_shapes(const Event& event, const MotionKnot& before, const MotionKnot& after) const;
  // `earlier`: the knot at which the piece before began, if there is one.
  void add_event(const FiredEvent& fired, const MotionKnot* earlier, const MotionKnot& before, const MotionKnot& after);
  [[nodiscard]] double calc_time_uncertainty(const Requirement& requirement, double time) const;
  void update_shared(const StepReport& report);

  const Scenario& scenario_;
  const Simulation& simulation_;
  const AnalysisRequest request_;
  std::vector<double> received_;           // scratch
  std::vector<double> inputs_;             // of the latest step
  std::optional<std::int32_t> redundant_;  // number of redundant rows at the latest state
  MotionWindow window_;
  ClearanceHistory clearance_;
  ContactHistory contacts_;
  PeakReactions peaks_;
  RequirementMonitor requirements_;
  SeparationMonitor separations_;
  NoticeWatch accuracy_;
  UnseenClearances unseen_clearances_;
  UnseenCrossings unseen_crossings_;
  UnseenEngagements unseen_engagements_;
};

// Returns the tick nearest to a time.
std::int64_t calc_nearest_tick(double time, double dt);

}  // namespace unlatch::hil
