// Pushers, stops and cords that engage and part again within a step, or the other way round: neither of both events
// acts, since a step looks at its ends. Their depth within a step is that of the interpolated poses (motion_window.h):
// it is searched where it rises at one end of a piece and falls at the other, or the other way round, by rates that can
// bring it so far. Cost: two depths for each such force and piece.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "hil/run/motion/joint_frame.h"
#include "hil/run/motion/motion_window.h"
#include "unlatch/model.h"
#include "unlatch/readings.h"

namespace unlatch::hil {

struct UnseenEngagement {
  int event = 0;               // index in the model: the one of both that was due first
  int force = 0;               // number among the one-sided forces
  double from = 0, until = 0;  // s: when it was due, and the other one
};

class UnseenEngagements {
 public:
  // Keeps nothing of the model; `model`: with the events of complete_events().
  explicit UnseenEngagements(const Model& model);

  // Of the piece between these knots, to which the window has moved. Valid until the next call.
  std::span<const UnseenEngagement> find(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to);

 private:
  // A one-sided force with events of its own.
  struct Force {
    OneSided own;
    int number = 0, begin = 0, end = 0;  // events that engage it and end that: indices in the model
    std::size_t element = 0;
    double limit = 0;
    std::optional<JointGeometry> joint{};
    std::optional<CordDrum> drum{};
    std::size_t drum_number = 0;
  };
  struct Depth {
    double value, rate;  // m and m/s, or rad and rad/s
  };
  // `near`: the knot that turns are counted from.
  static Depth calc(const Force& force, const MotionKnot& near, const BodyState& base, const BodyState& follower);
  void find(const Force& force, const MotionWindow& window, const MotionKnot& from, const MotionKnot& to);

  std::vector<Force> forces_;
  std::vector<UnseenEngagement> found_;
};

}  // namespace unlatch::hil
