// Events on the distance of two sets of shapes whose instant no tick shows: within a step the distance fell below the
// threshold and rose again, so that the event did not act. Contacts search for such touches (kernel/events), conditions
// of events do not.
#pragma once

#include <span>
#include <vector>

#include "hil/run/motion/motion_window.h"
#include "hil/run/motion/shape_dips.h"
#include "hil/scenario/scenario.h"
#include "hil/scenario/shapes/clearance.h"

namespace unlatch::hil {

struct UnseenClearance {
  int event = 0;               // index in the model
  double time = 0, value = 0;  // s, m: the least distance within the step
};

class UnseenClearances {
 public:
  explicit UnseenClearances(const Scenario& scenario);

  // Of the piece to which the window has moved. Valid until the next call.
  std::span<const UnseenClearance> find(const MotionWindow& window);

 private:
  // A condition "the distance is below": alone, or a part of an event's condition.
  struct Guard {
    int event = 0;
    double threshold = 0;      // m
    std::size_t a = 0, b = 0;  // bodies, as in MotionPiece
  };
  struct Listed;
  explicit UnseenClearances(const Listed& listed);

  std::vector<Guard> guards_;  // each has the pair of its number in the monitor
  ClearanceMonitor monitor_;
  std::vector<ShapeDips> dips_;  // of each guard
  std::vector<UnseenClearance> found_;
};

}  // namespace unlatch::hil
