// Notices of a run that its step does not resolve, each once with its first time. Watched off the cyclic thread, beside
// the other analyses of a run. Thresholds: kernel/THEORY.md, 8.
//
//   rotation   |w|·dt of a body beyond kAccurate
//   spring     dt·ω or dt·decay of a spring that is on, in the modes that hold, beyond kAccurate
//   contact    sqrt(k/m)·h of a closed contact, or h times the decay of its slip, beyond kAccurate; closed at the start
//   friction   dt times the rate at which friction in a joint, a pusher or a stop stops its motion, beyond kAccurate
//   mode       dt·ω of a mode of a flexible body beyond kAccurate
//   command    a commanded value that turns back and forth faster than dt·ω = kAccurate: a loop that its delay of a
//              tick and its hold rule
//   search     the search for events within a step reached a bound on its work: events left to the next tick, an
//              instant that is known badly, a touch that may have gone unseen
//   drift      a row's position residual; norm: of a body's quaternion
//   direction  a loaded spring whose two points coincide, to kCoincident, at a tick: its force has no direction
//   energy     what no force explains, beyond kEnergyNotice of the largest energy; beyond kEnergyFailure the run failed
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hil/notices/energy_audit.h"
#include "hil/scenario/scenario.h"

namespace unlatch::hil {

struct RunNotice {
  double time = 0;            // s
  std::string name, subject;  // name: as above
  std::string text;           // a sentence
};

inline constexpr double kCoincident = 1e-9;  // m: below it the rounding of places decides where a line points
inline constexpr double kEnergyNotice = 1e-3, kEnergyFailure = 0.1;  // of EnergyBalance::scale

class AccuracyWatch {
 public:
  AccuracyWatch(const Scenario& scenario, const Simulation& simulation);

  void update(const StepReport& report);  // after the initial state (a default report), and after each step
  [[nodiscard]] const std::vector<RunNotice>& get() const { return notices_; }
  [[nodiscard]] const EnergyBalance& get_energy() const { return audit_.get(); }
  // The motion is not that of the model: the unexplained energy has been beyond kEnergyFailure. Empty, or a sentence.
  [[nodiscard]] std::string describe_failure() const;

 private:
  // The course of a commanded value.
  struct Course {
    double value = 0;
    int direction = 0;         // of its last change
    std::int64_t turned = -1;  // tick of its last turn
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
  std::vector<bool> turning_, denormal_, stiff_, restless_;  // bodies, bodies, elements, channels that were told
  std::vector<bool> pointless_;                              // point springs that were told to have no direction
  std::vector<bool> unresolved_;                             // contacts that were told
  std::vector<bool> sticking_;                               // elements whose friction was told
  std::vector<ElementMobility> mobilities_;                  // in the present modes
  std::vector<Course> courses_;
  bool postponed_ = false, unlocated_ = false, unseen_ = false;  // searches for events that were told
  bool drifted_ = false, begun_ = false, unexplained_ = false, failed_ = false;
  double failed_time_ = 0;
  std::vector<std::byte> memory_;
  Workspace workspace_;  // of frequencies
};

}  // namespace unlatch::hil
