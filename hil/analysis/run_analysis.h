// Results of a run for engineers, gathered step by step off the cyclic thread: the event timeline, samples, clearances,
// separations, peak reactions, audits, and the verdict on the requirements. A run in the loop is analysed by replaying
// it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/analysis/clearance_history.h"
#include "hil/analysis/contact_history.h"
#include "hil/analysis/motion_window.h"
#include "hil/analysis/notices.h"
#include "hil/analysis/requirements.h"
#include "hil/analysis/separations.h"
#include "hil/scenario/scenario.h"
#include "hil/simulation/simulation.h"
#include "unlatch/redundancy.h"

namespace unlatch::hil {

struct TimelineEntry {
  double time = 0;  // s
  std::string name, subject;
};

// A joint's reaction: multipliers of the rows that hold.
struct ReactionSample {
  std::string joint, mode;
  RowSet rows = 0;
  std::array<double, kRows> multipliers{};  // N, N m
};

struct Sample {
  std::int64_t tick = 0;
  double time = 0;
  std::vector<BodyState> bodies;
  std::vector<std::vector<double>> modal;  // per body: its modal coordinates
  std::vector<ReactionSample> reactions;
};

// A body let go: its state at the instant at which a joint to it became free.
struct TipOff {
  double time = 0;
  std::string body, base, joint;  // base: what it was joined to
  Vec3 w{};                       // body axes, rad/s
};

struct PeakReaction {
  double value = 0, time = 0;  // signed, of the largest size so far; N or N m, s
};

// Reactions that were not unique, from one time to another: rows of their joints were redundant.
struct SharedReactions {
  RedundantRows rows;
  double from = 0, until = 0;  // s
  bool lasts = false;          // at the latest state
};

class RunAnalysis {
 public:
  // `samples`: ticks at which to take a sample, in any order.
  // The simulation keeps its motion from now on.
  RunAnalysis(const Scenario& scenario, Simulation& simulation, std::vector<std::int64_t> samples);

  // Looks at the state as it is, and at what its last step reported (a default report for the initial state).
  void update(const StepReport& report);

  std::vector<TimelineEntry> timeline;
  std::vector<Sample> samples;
  std::vector<TipOff> tip_offs;
  std::vector<EventAudit> audits;
  std::vector<std::array<PeakReaction, kRows>> peaks;  // per joint
  std::vector<SharedReactions> shared;                 // in the order in which they began
  const std::vector<Clearance>& clearances() const { return clearance_.get(); }
  // Witnesses and nearest shapes of clearance number `pair` when it was smallest.
  [[nodiscard]] PairDistance calc_witnesses(int pair) const { return clearance_.calc_witnesses(pair); }
  // Of the run so far.
  [[nodiscard]] std::vector<Verdict> judge() const { return requirements_.judge(window_); }
  [[nodiscard]] std::vector<Separation> list_separations() const { return separations_.list(clearance_); }
  [[nodiscard]] std::vector<ContactRecord> list_contacts() const { return contacts_.list(); }
  const AccuracyWatch& accuracy() const { return accuracy_; }  // notices, energy
  std::int64_t postponed = 0;                                  // event instants left to a later tick

 private:
  void add_motion(std::span<const FiredEvent> events);
  void add_event(const FiredEvent& fired, const MotionKnot& after);
  void take_sample();
  void update_shared(const StepReport& report);

  const Scenario& scenario_;
  const Simulation& simulation_;
  std::vector<std::int64_t> sample_ticks_;  // ascending
  std::size_t next_sample_ = 0;
  std::optional<std::int32_t> redundant_;  // rows, at the latest state
  MotionWindow window_;
  ClearanceHistory clearance_;
  ContactHistory contacts_;
  RequirementMonitor requirements_;
  SeparationMonitor separations_;
  AccuracyWatch accuracy_;
};

// The tick nearest to a time.
std::int64_t calc_nearest_tick(double time, double dt);

}  // namespace unlatch::hil
