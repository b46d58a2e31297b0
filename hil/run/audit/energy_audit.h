// Audit of energy over a whole run: the work of each source, and the energy that no force explains.
//
// Between two ticks the change of kinetic and stored energy must equal the work of loads, weight, motors, dampers,
// modes and leaving mass; an event may add the energy that its plastic impulse removes. Work is the integral of powers
// at the ticks: by Adams and Moulton's formulas through four or three of them (E. Hairer, Nørsett, Wanner: Solving
// Ordinary Differential Equations I, III.1), by the trapezoidal rule next to events, changed commands and corners of
// loads' tables or of laws. A power that changes within a step is not known from its ticks alone, so that the balance
// is a figure for people, and no verdict: what the step does not resolve is found by the audit of the step
// (step_audit.h). All energies are relative to the centre of mass, so that a flight speed of km/s hides nothing; ticks
// in which a joint or contact holds a body to the ground are relative to the ground. Cost: one pass over bodies and
// elements a tick; off the cyclic thread.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/energy.h"

namespace unlatch::hil {

// Energies, J, all from the start of the run.
struct EnergyBalance {
  std::array<double, kPowerSources> work{};  // by PowerSource
  double impulses = 0;                       // energy that closing rows removed from the motion, ≤ 0
  double strain = 0;                         // energy that springs, modes and contacts returned to the motion
  double contacts = 0;                       // energy that contacts dissipated, ≤ 0
  double kinetic = 0;                        // gained
  double numerical = 0;                      // lost to numerical damping while an implicit element is on, ≤ 0
  double unexplained = 0;                    // kinetic less all of these
  double largest = 0, largest_time = 0;      // unexplained energy of the largest size so far; s
  double scale = 0;  // largest kinetic and stored energy so far, at least that of 1 µm/s: the scale of the others
};

// The balance as one observer sees it. His frame moves at a constant velocity within a tick; flows are as he sees them.
class EnergyObserver {
 public:
  void begin(const EnergyFlow& flow);
  // One tick: from `start` over its pieces to `reached`. `smooth`: no event, command or corner in it.
  void begin_tick(bool smooth);
  void add_piece(const EnergyFlow& from, const EnergyFlow& to, double h);
  void add_impulse(double kinetic);
  void finish_tick(const EnergyFlow& start, const EnergyFlow& reached, bool implicit, double time);
  // The ticks before do not lead on smoothly to the next.
  void forget() { known_ = 0; }

  [[nodiscard]] const EnergyBalance& get() const { return balance_; }

 private:
  void add_trapezoid(const EnergyFlow& from, const EnergyFlow& to, double h);
  void add_smooth(const EnergyFlow& from, const EnergyFlow& to, double h);

  EnergyFlow earlier_{}, oldest_{};  // at the beginnings of the last two ticks
  int known_ = 0;                    // how many of them the present tick continues smoothly
  bool smooth_ = false;              // the present tick
  double tick_work_ = 0;             // J
  EnergyBalance balance_;
};

class EnergyAudit {
 public:
  explicit EnergyAudit(const Simulation& simulation);

  // Updates the balances after the initial state (a default report) and after each step.
  void update(const StepReport& report);
  // As an observer sees it who follows the centre of mass, or stands on the ground that holds the system.
  [[nodiscard]] const EnergyBalance& get() const { return following_.get(); }

 private:
  void begin();
  void add_tick(const StepReport& report);
  // Powers at the start of the last tick, with the commands of its step, which may be new.
  EnergyFlow calc_start(bool& smooth);
  [[nodiscard]] bool is_implicit() const;
  // True if the table of a load that is on has a knot between the two times, s.
  [[nodiscard]] bool has_corner(double from, double to) const;
  void keep(const EnergyFlow& flow, const AuditFrame& frame);

  const Simulation& simulation_;
  std::vector<int> implicit_;      // elements that the plan integrates implicitly
  bool implicit_modes_ = false;    // implicit modes of flexible bodies
  bool corners_ = false;           // laws that forces read have corners, at which steps are split
  std::vector<std::byte> memory_;  // memory of the audit's own evaluations
  Workspace workspace_;
  std::vector<std::uint64_t> block_;  // state before the last step
  State before_;
  std::vector<double> inputs_;
  AuditFrame frame_{};  // the observer of now_
  EnergyFlow now_{};    // at the last tick, relative to the centre of mass
  bool begun_ = false;
  bool grounded_ = false;  // the last tick was seen from the ground
  EnergyObserver following_;
};

}  // namespace unlatch::hil
