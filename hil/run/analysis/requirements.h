// Verdict of a run: the value of each requirement, its margin, its time, and the decision "met", "not met" or
// "unresolved". Minima and maxima are located inside the steps; values at an event are those of its instant.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hil/run/analysis/event_rounds.h"
#include "hil/run/extremes/extreme_bounds.h"
#include "hil/run/extremes/finer_steps.h"
#include "hil/run/extremes/law_extremes.h"
#include "hil/run/extremes/smooth_part.h"
#include "hil/run/motion/clearance_history.h"
#include "hil/run/motion/contact_history.h"
#include "hil/run/motion/extreme.h"
#include "hil/run/motion/joint_frame.h"
#include "hil/run/motion/motion_window.h"
#include "hil/scenario/scenario.h"
#include "unlatch/step.h"

namespace unlatch::hil {

struct Verdict {
  std::size_t requirement = 0;  // index into Scenario::requirements
  bool evaluated = false;       // false: `why` gives the reason
  std::string why;              // "event 'release:booster1' did not occur"
  double value = 0, limit = 0;  // in the requirement's unit; the nearest limit
  double margin = 0;            // distance of the value from the limit, positive within it; below 0: not met
  double time = 0;              // time of the value, s
  // Of a reaction or the force of a contact: a blow in the interval, whose impulse there is no force; infinity: none. s
  double blow = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool leaves_out_blow() const { return blow < std::numeric_limits<double>::infinity(); }
  // How far the value may be wrong: between knots (extreme_bounds.h), and by the errors of the steps
  // (step_uncertainty.h). Infinity: not known, since the step does not resolve what the value depends on.
  double uncertainty = 0;
  [[nodiscard]] bool is_error_known() const { return uncertainty < std::numeric_limits<double>::infinity(); }
  // The value is that of a tick or an event, and may be beyond it in between: new commands came, or other events, at
  // both ends of the step, and it was not taken again (finer_steps.h).
  bool at_ticks = false;
  // Part of the value that its uncertainty may be without a word.
  static constexpr double kExact = 1e-3;
  [[nodiscard]] bool is_uncertain() const { return evaluated && uncertainty > kExact * std::abs(value); }
  // Cause, if the value depends on something that the step did not resolve: then it is neither met nor missed.
  std::string unresolved;
  [[nodiscard]] bool is_resolved() const { return unresolved.empty(); }
  [[nodiscard]] bool is_met() const { return is_resolved() && evaluated && margin >= 0; }
};

// True for an extreme of what is known at knots alone, or of an expression of what is: its verdict has an uncertainty.
bool is_bounded(const Model& model, const Requirement& requirement);

class RequirementMonitor {
 public:
  // Keeps references to all arguments.
  RequirementMonitor(const Scenario& scenario, const Simulation& simulation, const ClearanceHistory& clearances,
                     const ContactHistory& contacts);

  // Called after each step of the simulation, before its pieces of motion are added.
  void begin_step(const StepReport& report);

  // Adds the rounds of events of an instant (event_rounds.h).
  void add_events(std::span<const EventRound> rounds);
  // Adds the piece between these knots, with these commands, to which the window and the clearances have already moved.
  // `switched`: events or new commands are at its beginning, at which forces may jump where no acceleration does.
  void add_piece(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to,
                 std::span<const double> commands, bool switched);
  // Adds the values of all sensors as flight software receives them, at the end of a tick; they hold until the next.
  void add_received(double time, std::span<const double> values);
  // Verdicts on the run so far, whose end is the end of the window.
  [[nodiscard]] std::vector<Verdict> judge(const MotionWindow& window) const;
  // End of the interval of requirement number i, s; infinity while it goes on.
  [[nodiscard]] double get_end(std::size_t i) const;
  // Quantity of requirement number i at the latest knot, in the requirement's unit; NaN outside its interval, and for
  // requirements on events.
  [[nodiscard]] double get_now(std::size_t i) const;

 private:
  enum class Phase { kWaiting, kOpen, kClosed };
  struct Track {
    const Requirement* requirement = nullptr;
    std::optional<JointGeometry> joint;
    int pair = -1;                                          // number of the clearance pair
    std::vector<int> reactions;                             // joints whose reactions it is, or reads
    std::vector<int> forces;                                // contacts, likewise of their forces
    double blow = std::numeric_limits<double>::infinity();  // as Verdict::blow
    std::size_t first = 0;                                  // index of a sensor's first value
    Phase phase = Phase::kOpen;
    Smallest low, high;                     // `high`: minimum of the negative
    ExtremeBounds bounds;                   // instead, of what is known at knots alone
    std::optional<LawExtremes> law;         // instead, of a quantity that is a law
    bool jumps = false;                     // it may jump where forces do and no acceleration does
    bool goes_on = false;                   // smoothly where the motion has a corner of its accelerations
    SmoothPart part = SmoothPart::kItself;  // of the quantity, which the curve and its bounds are of
    bool judged = false;                    // a copy, for a verdict
    bool bounded = false;                   // as is_bounded()
    bool straight = false;                  // a straight line between events: its extremes are at knots
    bool has_last = false, fresh = true;
    bool skips = false;           // the latest piece, in which the smallest clearance could not change: `last` is older
    bool apart = false;           // the latest piece had its contact open, so that it had no force and no depth
    bool counts_between = false;  // its values between two rounds of events count: it is no force
    bool lost = false;            // it begins or ends at an event of a round whose states are not kept
    double end = std::numeric_limits<double>::infinity();  // s, of the interval
    // s, of a time from one event to another: the first occurrence of the latter, not before the first of the former.
    double next = std::numeric_limits<double>::quiet_NaN();
    double last = 0, last_time = 0;  // value and time at the end of the latest piece, or of the instant
    double tolerance = 0;            // of a distance, m: its error, by which a limit that is missed is met
  };

  [[nodiscard]] double calc_sample(const Track& track, const MotionKnot& knot) const;
  class FinerOfTrack;
  void add_to_bounds(Track& track, double time, double value, bool begins) const;
  template <class BodyAt>
  [[nodiscard]] double calc_of_bodies(const Track& track, const BodyAt& body_at) const;
  [[nodiscard]] double calc_at(const Track& track, const MotionKnot& knot) const;
  [[nodiscard]] double calc_within(const Track& track, const MotionWindow& window, double time) const;
  void finish(Track& track, const MotionWindow& window) const;
  static void take(Track& track, double time, double value);
  [[nodiscard]] FinerSource get_finer(const Track& track) const;
  [[nodiscard]] Verdict judge(Track track, const MotionWindow& window) const;
  void add_blow(Track& track, const MotionKnot& before, const MotionKnot& after) const;
  // An event that acted at an instant, and the number of its round among those of the instant.
  struct Acted {
    FiredEvent fired;
    std::size_t round;
  };
  [[nodiscard]] std::vector<Acted> list_acted(std::span<const EventRound> rounds) const;
  void add_times(std::span<const Acted> acted);
  void add_round(Track& track, std::span<const EventRound> rounds, std::size_t number, std::span<const Acted> acted);
  [[nodiscard]] Verdict judge_times(const Track& track) const;
  [[nodiscard]] const EventName* find_missing(const Requirement& requirement) const;

  const Scenario& scenario_;
  const Simulation& simulation_;
  const ClearanceHistory& clearances_;
  const ContactHistory& contacts_;
  std::vector<Track> tracks_;
  std::vector<double> received_;  // present values of all sensors as received
  // The first occurrence of an event. Rounds are numbered through the run: of two events of one time they are the
  // order.
  struct Occurrence {
    double time = std::numeric_limits<double>::quiet_NaN();  // s
    std::size_t round = 0;
    [[nodiscard]] bool is_known() const { return std::isfinite(time); }
  };
  std::vector<Occurrence> first_;      // by event
  std::size_t rounds_ = 0;             // so far
  std::unique_ptr<FinerSteps> finer_;  // where some requirement may need them
  const MotionWindow* window_ = nullptr;
};

}  // namespace unlatch::hil
