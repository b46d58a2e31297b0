// Separations: pairs of assemblies that joints held together and no longer do, with the numbers by which a separation
// is judged. Two bodies that part while they are still joined through others, as two halves of a fairing that swing on
// their hinges, are a pair too: its sides are what moves with each of them as one rigid body.
//
//   release        the instant at which the last joint between the two becomes free
//   end of push    the instant at which the last spring or pusher between them ceases to act: a pusher at its free
//                  length, any other when it is switched off; the release if none acts; the end of the run while one
//                  acts
//   axis           of the base body's axes (of W's, if the base is the ground) that nearest to the relative velocity of
//                  the two centres of mass at the end of push, with its sign
//
// All rates and velocities are those of the end of push. Rates are of the two bodies that the last joint connected,
// their axial part is that about the separation axis. Coning: hil/run/analysis/assemblies.h.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hil/run/analysis/assemblies.h"
#include "hil/run/analysis/spring_work.h"
#include "hil/run/motion/clearance_history.h"

namespace unlatch::hil {

// Angular velocity about the separation axis and across it, rad/s.
struct SplitRate {
  double axial = 0, transverse = 0;  // with sign; size
};

struct Push {
  std::string spring;
  double impulse = 0, work = 0;  // since the release: N s (size of the vector; N m s of a torque), J
};

// One side of a separation.
struct SeparatedSide {
  int body = kGround;       // body of the last joint
  std::vector<int> bodies;  // bodies of the assembly, kGround included
  SplitRate rate;           // angular velocity in W
  Coning coning;
  bool has_coning = false;  // false for the ground
};

struct Separation {
  SeparatedSide base, follower;
  std::string joint;             // the last joint
  double release = 0, end = 0;   // s
  bool pushes = false;           // a spring still acts at the end of the run
  bool rejoined = false;         // a joint has joined them again
  bool indirect = false;         // at the release they were still joined through other bodies
  std::string axis;              // "+x of core"
  double along = 0, across = 0;  // m/s: velocity of the follower's centre of mass relative to the base's
  SplitRate relative;            // angular velocity of the follower relative to the base
  std::vector<Push> pushers;
  int pair = -1;  // index in Scenario::clearance: the pair that came nearest after the release; -1: none watched
};

class SeparationMonitor {
 public:
  // `pushes`: compute the impulses and works of springs.
  SeparationMonitor(const Scenario& scenario, bool pushes);

  // Adds events that acted between two knots. Reports the released bodies to the clearances.
  void add_events(const MotionKnot& before, const MotionKnot& after, ClearanceHistory& clearances);
  void add_piece(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to);
  [[nodiscard]] std::vector<Separation> list(const ClearanceHistory& clearances) const;

 private:
  struct Track {
    Separation separation;             // without the results of measure()
    std::vector<BodyState> bodies;     // states at the end of push, as known so far
    std::vector<double> burnt;         // kg, at the same time
    std::vector<std::size_t> springs;  // indices in springs_ of those between the two
    std::vector<SpringWork::Sum> sums;
    bool over = false;  // the two are joined again
  };
  // `now`: assemblies after the release; of an indirect pair the rigid ones.
  void open(std::size_t joint, const Assemblies& now, bool indirect, const MotionKnot& after,
            ClearanceHistory& clearances);
  [[nodiscard]] RowSet get_rows(const State& state, std::size_t joint) const;
  // True if some joint with rows connects the two rigid assemblies of these bodies.
  [[nodiscard]] bool are_connected(const State& state, const Assemblies& rigid, int a, int b) const;
  static void set_end(Track& track, double time, std::span<const BodyState> bodies, std::span<const double> burnt);
  // Computes the numbers of the end of push.
  void measure(const Track& track, Separation& pair) const;

  const Model model_;  // with its markers placed
  const bool pushes_;
  std::vector<SpringWork> springs_;
  std::vector<Track> tracks_;
};

}  // namespace unlatch::hil
