// Audit of springs and modes that are integrated implicitly, since the step resolves no period of them. The method
// keeps their mean but not their overshoot, which the audit of bodies (audit/step_audit.h) sees only where it is a part
// of a body's motion that matters. A force within such a spring that changes abruptly, between two ticks, makes the
// true spring swing about its new mean by as much, undamped; one that changes smoothly does not (E. Hairer, Wanner:
// Solving Ordinary Differential Equations II, IV.15, on stiff components that a method damps).
//
// Error of a force: half of the third difference of its values at ticks, which is its jump for a jump, and (h·Ω)³/2 of
// it for one that swings slowly at Ω, times the overshoot of the spring's own damping, exp(−πζ/√(1 − ζ²)), or that of
// the method, 0.21; and the difference from two half steps, summed as the method forgets it. Of its speed: the latter
// alone. Compared with the largest change of the same value since the start. Of a flexible body: the modal forces ω²η,
// overshoots of those of the modes that the step does not resolve against those of all, and the modal rates. Cost: a
// reading for each such spring or mode and tick; nothing without them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/frequencies.h"

namespace unlatch::hil {

// What the method leaves out of a spring or of the modes of a body.
struct ImplicitError {
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  int element = kNone;    // the spring, in the one numbering of elements; or
  int body = kNone;       // the flexible body
  bool of_speed = false;  // the speed of the spring's coordinate, or of the modes, is wrong, and its force is not
  double error = 0;       // N or N m; of modes N/kg^0.5; of a speed m/s or rad/s, of modes kg^0.5 m/s
  double change = 1;      // largest change of the same value since the start
  double size = 0;        // h·ω or h·decay, the largest so far
  double time = kNever;   // s, since when it is beyond the limit
  double from = kNever;   // s, the error came up between the two
  double until = kNever;  // s, until when, if it is no more
};

class ImplicitAudit {
 public:
  // Keeps a reference.
  explicit ImplicitAudit(const Simulation& simulation);

  // Rates in the modes of the joints from now on.
  void set_rates(std::span<const ElementFrequency> frequencies);
  // Called after the initial state and after each step, and after set_rates() if that is called.
  void update();
  // The latest step was taken again as two halves; `between`: ticks since the one before that was.
  void compare(const Plan& halved, const State& state, const Workspace& workspace, double between);

  [[nodiscard]] std::vector<ImplicitError> list_unresolved() const;
  [[nodiscard]] std::vector<ImplicitError> list_passed() const;

 private:
  static constexpr double kNever = ImplicitError::kNever;
  // A value at the latest ticks.
  struct Course {
    double earlier[3] = {0, 0, 0};
    void restart(double value) { earlier[0] = earlier[1] = earlier[2] = value; }
    double move(double value) {  // the third difference
      const double difference = value - 3 * earlier[0] + 3 * earlier[1] - earlier[2];
      earlier[2] = earlier[1];
      earlier[1] = earlier[0];
      earlier[0] = value;
      return difference;
    }
  };
  // An error so far, and since when it is beyond the limit.
  struct Sum {
    double error = 0, change = 0, latest = 0;
    double time = kNever, from = kNever;
    double passed_from = kNever, passed_until = kNever;
    // The difference that a step makes; `memory`: what a step leaves of it; `between`: ticks since the one before.
    void add(double own, double memory, double between) {
      const double remembered = memory < 1 ? std::min(between, 1 / (1 - memory)) : between;
      error = error * std::pow(memory, between + 1) + own + remembered * std::min(own, latest);
      latest = own;
    }
  };
  struct Spring {
    int element = kNone;
    double stiffness = 0;
    double omega = 0, decay = 0, size = 0;  // now, and h times the largest so far
    double start = 0, start_rate = 0, greatest = 0;
    Course force;
    double jump = 0;
    Sum forces, speeds;
  };
  struct Modes {
    int body = kNone;
    double size = 0;
    // Of each mode: ω², 1/s²; its overshoot, 0 if the step resolves it; what a step leaves of an error; at the start.
    std::vector<double> squares{}, overshoots{}, memories{}, starts{}, start_rates{};
    std::vector<Course> courses{};
    std::vector<Sum> own_forces{}, own_speeds{};  // of each mode: the errors alone
    std::vector<double> differences{};            // of a step from two half steps
    double greatest = 0, jump = 0;
    Sum forces{}, speeds{};
  };

  void update(Spring& spring);
  void update(Modes& modes);
  void judge(Sum& sum, double error, double ticks) const;
  static double add(std::vector<Sum>& own, const Modes& modes, double between);
  [[nodiscard]] double calc_least_force(const Spring& spring) const;
  static void list(const Sum& sum, double error, ImplicitError own, bool passed, std::vector<ImplicitError>& list);
  [[nodiscard]] std::vector<ImplicitError> list(bool passed) const;

  const Simulation& simulation_;
  std::vector<Spring> springs_;
  std::vector<Modes> modes_;
  bool begun_ = false;
};

}  // namespace unlatch::hil
