// Notices about motions that the step does not resolve, one for each kind and subject, with its first time, its worst
// value and the time of that. Watched off the cyclic thread, beside the other analyses of a run. Thresholds:
// kernel/THEORY.md, 8. Those marked * make the results that depend on the subject's bodies unresolved
// (audit/unresolved_bodies.h): they are no results.
//
//   start*     the run goes on from a state of a run that was unresolved
//   rotation*  |w|·dt of a body beyond kAccurate
//   spring*    dt·ω or dt·decay of a spring that is on, in the present modes, beyond kAccurate; of an implicit one, as
//              of a mode, it is a notice only
//   overshoot* an implicit spring, or a body with implicit modes, whose force changes abruptly, or differs for steps of
//              half the length (implicit_audit.h); where it is only the speed of a spring's coordinate, the
//              requirements on it are unresolved, and all that depends on its bodies where anything reads that speed
//   profile*   a load's table whose impulse the step misses by more than kProfileError, an exponential profile with
//              dt / tau beyond kAccurate, or a sine with dt·omega beyond kSineAngle
//   contact*   sqrt(k/m)·h of a closed contact, or h times the decay of its slip, beyond kAccurate; closed at the
//              start;
//              a blow on several rough feet that is found to a part of its speeds only
//   jump*      the point of contact of a face or a straight line jumps from end to end, and more than kJumpNotice of
//              the bodies' rotation depends on which end bears the force; beyond kJumpFailure they are unresolved
//   seam*      two shapes of one surface push a shape at one point: its force is up to twice that of one surface;
//   beyond
//              kSeamFailure the bodies are unresolved
//   friction*  dt times the decay rate of a motion by friction in a joint, a pusher or a stop, beyond kAccurate
//   mode*      dt·ω of a mode of a flexible body beyond kAccurate
//   command    a commanded value that reverses faster than dt·ω = kAccurate: a control loop for which the delay of a
//              tick and the hold matter
//   search*    the search for events within a step reached a bound on its work: events left to the next tick, an
//              inaccurate instant, a touch that may have been missed; or an event's condition is not searched
//   delay      the condition of a repeating event became true again while its delay ran, for which it does not act
//   drift      a row's position residual; norm: that of a body's quaternion
//   direction* a loaded spring whose two points coincide, to kCoincident, at a tick: its force has no direction
//   cell*      a law that forces read looked a table up at places between which, from one tick to the next, there are
//              whole cells of one of its axes, which were not seen
//   law*       a law that forces read rises and falls, or jumps, between the instants at which a step evaluates it
//   beside*    a pusher with a guide pushes a follower whose point is farther beside the guide than the stroke is long:
//              it has come back, but not onto the pusher
//   table      a table whose axis says `ends: notice` was looked up beyond its ends, at a tick
//   step*      a body whose motion the step does not resolve, as steps of half the length show (step_audit.h), or the
//              derivative of its forces along what was flown (feedback_audit.h)
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hil/run/audit/contact_jumps.h"
#include "hil/run/audit/contact_seams.h"
#include "hil/run/audit/energy_audit.h"
#include "hil/run/audit/unresolved_bodies.h"
#include "hil/run/audit/unseen_crossings.h"
#include "hil/run/audit/unseen_engagements.h"
#include "hil/run/motion/unseen_clearances.h"
#include "hil/run/notices/cell_watch.h"
#include "hil/run/notices/feedback_audit.h"
#include "hil/run/notices/implicit_audit.h"
#include "hil/run/notices/profile_watch.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

class LawWatch;
class StepAudit;
struct StepError;

struct RunNotice {
  double time = 0;            // s, the first
  std::string name, subject;  // name: from the list above
  std::string text;           // one sentence, about the worst value
  double worst_time = 0;      // s, of the worst value
  bool unresolved = false;    // results that depend on the subject are unresolved
};

inline constexpr double kCoincident = 1e-9;   // m: below it the direction between two points is rounding
inline constexpr double kSeamFailure = 1e-3;  // of the depth: ContactSeam::part
inline constexpr double kJumpNotice = 1e-4, kJumpFailure = 1e-2;  // parts of the rotation: ContactJumpSum::calc_part()

class NoticeWatch {
 public:
  // `audits`: with the drift of joints and the audit of energy, which cost the most.
  NoticeWatch(const Scenario& scenario, const Simulation& simulation, bool audits = true);
  ~NoticeWatch();

  // The distance that an event waits for was below its threshold within a step.
  void report_unseen(const UnseenClearance& unseen);
  // The condition of an event held for a part of a step alone.
  void report_unseen(const UnseenCrossing& unseen);
  // A pusher, a stop or a cord engaged and parted again within a step, or the other way round.
  void report_unseen(const UnseenEngagement& unseen);
  // The condition of a repeating event became true again while its delay ran.
  void report_lost(const LostTrigger& lost);
  // Whether the condition of an event held for a part of a step alone is not searched.
  void report_unsearched(const UnsearchedEvent& unsearched);
  void update(const StepReport& report);  // called after the initial state (a default report), and after each step
  // Notices so far. Those of the audit of the step are about the whole run so far, and come last.
  [[nodiscard]] std::vector<RunNotice> get() const;
  [[nodiscard]] const EnergyBalance& get_energy() const { return audit_->get(); }  // with audits only
  // Sentence that names what is unresolved, or empty.
  [[nodiscard]] std::string describe_unresolved() const;
  [[nodiscard]] UnresolvedBodies get_unresolved() const;
  // Bodies whose steps make an error of more than this part of what their motion has changed: results that are as near
  // to their limits as that depend on it.
  [[nodiscard]] UnresolvedBodies get_doubtful(double part) const;
  [[nodiscard]] const StepAudit& get_steps() const { return *steps_; }

 private:
  // History of a commanded value.
  struct Course {
    double value = 0;
    int direction = 0;         // sign of its last change
    std::int64_t turned = -1;  // tick of its last reversal
    int quick_turns = 0;       // in succession
  };

  // One notice of a kind and subject so far; `number` is its place in the list, or -1.
  struct Slot {
    int number = -1;
    double worst = 0;
  };
  // Adds a notice, or makes it that of the worse value. `describe` gives the sentence.
  template <class Describe>
  void report(Slot& slot, const char* name, const std::string& subject, double size, const Describe& describe,
              std::span<const int> unresolved = {});
  void add(std::string name, std::string subject, std::string text, std::span<const int> unresolved = {});
  void watch_bodies();
  void watch_springs();
  void watch_directions();
  void watch_guides();
  void watch_profiles();
  void watch_tables();
  void watch_cells(const StepReport& step);
  void watch_laws();
  void watch_feedback();
  [[nodiscard]] Vec3 calc_point(int body, const Eigen::Vector3d& point) const;
  void watch_contacts();
  void watch_jumps();
  void watch_seams();
  void watch_friction(bool modes_are_new);
  void watch_commands();
  void watch_loops(const StepReport& report);
  void watch_drift();
  void watch_search(const StepReport& report);
  void watch_links(const StepReport& report);
  void add_unresolved(std::span<const int> bodies, const std::string& cause);
  [[nodiscard]] std::string describe(const StepError& error) const;
  [[nodiscard]] std::string describe(const ImplicitError& error) const;
  [[nodiscard]] const std::string& get_subject(const ImplicitError& error) const;
  [[nodiscard]] bool is_read(const ImplicitError& error) const;
  [[nodiscard]] std::vector<int> list_bodies(const ImplicitError& error) const;
  void add_unresolved(const ImplicitError& error, UnresolvedBodies& unresolved) const;

  const Scenario& scenario_;
  const Simulation& simulation_;
  const double dt_;
  const std::unique_ptr<StepAudit> steps_;
  ImplicitAudit implicit_;
  FeedbackAudit feedback_;
  std::optional<EnergyAudit> audit_;
  std::vector<RunNotice> notices_;
  UnresolvedBodies unresolved_;
  BodyLinks links_;
  std::vector<Slot> turning_;                       // of bodies
  std::vector<Slot> stiff_, sticking_;              // of elements
  std::vector<Slot> touching_, jumping_, doubled_;  // of contacts
  std::vector<double> impulses_;                    // of contacts at the latest tick, N s
  std::vector<bool> denormal_, restless_;           // reported bodies, channels
  std::vector<bool> pointless_, pointless_sided_;   // reported point springs, one-sided forces
  std::vector<Slot> profile_notices_;               // of loads
  std::vector<Slot> left_, skipped_;                // of tables
  Slot yielded_;                                    // of blows
  std::vector<Slot> beside_;                        // of one-sided forces
  std::vector<Slot> passed_, passed_over_;          // of events; of laws
  std::vector<bool> lost_;                          // events reported: triggers during their delays
  std::vector<ProfileWatch> profiles_;              // of loads
  CellWatch cells_;
  ContactJumps jumps_;
  ContactSeams seams_;
  std::unique_ptr<LawWatch> laws_;
  std::vector<ElementMobility> mobilities_;  // in the present modes
  std::vector<Course> courses_;
  bool postponed_ = false, unlocated_ = false, unseen_ = false, cornered_ = false,
       settled_ = false;           // reported searches for events
  std::int32_t redundant_ = 0;     // rows of loops at the latest tick
  bool nearly_redundant_ = false;  // reported
  bool drifted_ = false, begun_ = false;
  std::vector<std::byte> memory_;
  Workspace workspace_;  // workspace of frequencies
};

template <class Describe>
void NoticeWatch::report(Slot& slot, const char* name, const std::string& subject, double size,
                         const Describe& describe, std::span<const int> unresolved) {
  if (slot.number >= 0 && size <= slot.worst) return;
  slot.worst = size;
  if (slot.number >= 0) {
    RunNotice& notice = notices_[static_cast<std::size_t>(slot.number)];
    notice.text = describe();
    notice.worst_time = simulation_.get_time();
    if (!unresolved.empty() && !notice.unresolved) {
      notice.unresolved = true;
      add_unresolved(unresolved, std::string(name) + " " + subject + ": " + notice.text);
    }
    return;
  }
  slot.number = static_cast<int>(notices_.size());
  add(name, subject, describe(), unresolved);
}

}  // namespace unlatch::hil
