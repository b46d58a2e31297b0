// Audit of energy over a whole run: what moved the bodies, and what no force explains.
//
// Between two ticks the change of kinetic and stored energy must equal the work of loads, weight, motors, dampers,
// modes and leaving mass; an event may add what its plastic impulse takes. Work is the integral of powers at the ticks:
// by the parabola through three of them (Adams–Moulton, error h⁴/24 d³P/dt³ a tick), by the trapezoid next to events
// and changed commands. All is seen from the centre of mass, so that a speed of flight of km/s hides nothing; ticks in
// which something holds a body to the ground are seen from there.
// Cost: one pass over bodies and elements a tick; off the cyclic thread.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "hil/simulation/simulation.h"
#include "unlatch/energy.h"

namespace unlatch::hil {

// J, all from the start of the run.
struct EnergyBalance {
  std::array<double, kPowerSources> work{};  // by PowerSource
  double impulses = 0;                       // what closing rows took from the motion, ≤ 0
  double strain = 0;                         // what springs, modes and contacts gave back to the motion
  double contacts = 0;                       // what contacts took from the motion and did not store, ≤ 0
  double kinetic = 0;                        // gained
  double numerical = 0;                      // lost to the method's own damping while an implicit element is on, ≤ 0
  double unexplained = 0;                    // kinetic less all of these
  double largest = 0, largest_time = 0;      // the unexplained of the largest size so far; s
  double scale = 0;  // largest kinetic and stored energy so far, at least that of 1 µm/s: what the rest is judged by
};

class EnergyAudit {
 public:
  explicit EnergyAudit(const Simulation& simulation);

  // After the initial state (a default report) and after each step.
  void update(const StepReport& report);
  [[nodiscard]] const EnergyBalance& get() const { return balance_; }
  // Size that rounding and the integrals of powers may explain, J.
  [[nodiscard]] double calc_doubt() const;

 private:
  void begin();
  void add_tick(const StepReport& report);
  // Of the start of the last tick with the commands that it was stepped with, which may be new.
  EnergyFlow calc_start();
  void add_work(const EnergyFlow& from, const EnergyFlow& to, double h);
  void add_stored(const EnergyFlow& from, const EnergyFlow& to);
  void add_smooth_work(const EnergyFlow& from, const EnergyFlow& to, double h);
  [[nodiscard]] bool is_implicit() const;
  void keep(const EnergyFlow& flow, const Vec3& frame);

  const Simulation& simulation_;
  std::vector<int> implicit_;      // elements that the plan integrates implicitly
  bool implicit_modes_ = false;    // of flexible bodies
  std::vector<std::byte> memory_;  // of the evaluations of the audit's own
  Workspace workspace_;
  std::vector<std::uint64_t> block_;  // the state before the last step
  State before_;
  std::vector<double> inputs_;
  Vec3 frame_{};                         // velocity of the observer of now_
  EnergyFlow earlier_{}, now_{};         // at the last tick but one, and at the last, seen from the centre of mass
  bool begun_ = false, smooth_ = false;  // smooth_: nothing has happened between the two
  bool at_rest_ = false;                 // they are seen from the ground
  double tick_work_ = 0, fastest_ = 0;   // J, of the tick; J, largest kinetic energy seen from rest
  double coarse_ = 0;                    // J: what trapezoids may miss
  EnergyBalance balance_;
};

}  // namespace unlatch::hil
