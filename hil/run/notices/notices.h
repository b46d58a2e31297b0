// Notices about motions that the step does not resolve, each once with its first time. Watched off the cyclic thread,
// beside the other analyses of a run. Thresholds: kernel/THEORY.md, 8.
//
//   rotation   |w|·dt of a body beyond kAccurate
//   spring     dt·ω or dt·decay of a spring that is on, in the present modes, beyond kAccurate
//   contact    sqrt(k/m)·h of a closed contact, or h times the decay of its slip, beyond kAccurate; closed at the start
//   friction   dt times the decay rate of a motion by friction in a joint, a pusher or a stop, beyond kAccurate
//   mode       dt·ω of a mode of a flexible body beyond kAccurate
//   command    a commanded value that reverses faster than dt·ω = kAccurate: a control loop for which the delay of a
//              tick and the hold matter
//   search     the search for events within a step reached a bound on its work: events left to the next tick, an
//              inaccurate instant, a touch that may have been missed
//   drift      a row's position residual; norm: that of a body's quaternion
//   direction  a loaded spring whose two points coincide, to kCoincident, at a tick: its force has no direction
//   energy     energy that no force explains, beyond kEnergyNotice of the largest; beyond kEnergyFailure the run failed
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hil/run/notices/energy_audit.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct RunNotice {
  double time = 0;            // s
  std::string name, subject;  // name: from the list above
  std::string text;           // one sentence
};

inline constexpr double kCoincident = 1e-9;  // m: below it the direction between two points is rounding
inline constexpr double kEnergyNotice = 1e-3, kEnergyFailure = 0.1;  // relative to EnergyBalance::scale

class NoticeWatch {
 public:
  NoticeWatch(const Scenario& scenario, const Simulation& simulation);

  void update(const StepReport& report);  // called after the initial state (a default report), and after each step
  [[nodiscard]] const std::vector<RunNotice>& get() const { return notices_; }
  [[nodiscard]] const EnergyBalance& get_energy() const { return audit_.get(); }
  // Sentence if the motion is not that of the model: the unexplained energy has been beyond kEnergyFailure. Else empty.
  [[nodiscard]] std::string describe_failure() const;

 private:
  // History of a commanded value.
  struct Course {
    double value = 0;
    int direction = 0;         // sign of its last change
    std::int64_t turned = -1;  // tick of its last reversal
    int quick_turns = 0;       // in succession
  };

  void add(std::string name, std::string subject, std::string text);
  void watch_bodies();
  void watch_springs();
  void watch_directions();
  void watch_contacts();
  void watch_friction(bool modes_are_new);
  void watch_commands();
  void watch_drift();
  void watch_search(const StepReport& report);
  void watch_energy();

  const Scenario& scenario_;
  const Simulation& simulation_;
  const double dt_;
  EnergyAudit audit_;
  std::vector<RunNotice> notices_;
  std::vector<bool> turning_, denormal_, stiff_, restless_;  // reported bodies, bodies, elements, channels
  std::vector<bool> pointless_;                              // point springs reported as without direction
  std::vector<bool> unresolved_;                             // reported contacts
  std::vector<bool> sticking_;                               // elements with reported friction
  std::vector<ElementMobility> mobilities_;                  // in the present modes
  std::vector<Course> courses_;
  bool postponed_ = false, unlocated_ = false, unseen_ = false;  // reported searches for events
  bool drifted_ = false, begun_ = false, unexplained_ = false, failed_ = false;
  double failed_time_ = 0;
  std::vector<std::byte> memory_;
  Workspace workspace_;  // workspace of frequencies
};

}  // namespace unlatch::hil
