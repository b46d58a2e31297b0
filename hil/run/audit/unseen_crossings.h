// Events whose instants no knot shows: between two knots a condition on quantities became true, and false again, so
// that the event did not act. Guards are known at knots alone; between them the quantities are the polynomials through
// the latest five knots of a smooth run, of the size of a vector those of its square. Distances of shapes have their
// own search (unseen_clearances.h). Conditions on forces of pushers and cords and on burnt masses are not searched, nor
// are quantities that change too abruptly from knot to knot for a polynomial. Cost: some quantities for each event that
// compares any, and knot.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hil/run/motion/joint_frame.h"
#include "hil/run/motion/motion_window.h"
#include "hil/run/motion/sampled_curve.h"
#include "unlatch/model.h"

namespace unlatch::hil {

struct UnseenCrossing {
  int event = 0;               // index in the model
  double from = 0, until = 0;  // s, while its condition held
};

class UnseenCrossings {
 public:
  // Keeps a reference.
  explicit UnseenCrossings(const Model& model);

  // Of the piece between these knots, to which the window has moved, and the one before it. Valid until the next call.
  std::span<const UnseenCrossing> find(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to);

 private:
  // A condition without parts: its quantity at the latest knots, or true or false.
  struct Leaf {
    Condition condition;
    std::optional<JointGeometry> joint{};
    bool squared = false;  // the values are squares
    bool holds = false;    // of one that is true or false from event to event
    double times[kCurvePoints] = {}, values[kCurvePoints] = {};
    int count = 0;
    std::optional<double> latest{};
  };
  struct Guard {
    int event = 0;
    bool repeats = false;
    std::vector<Leaf> leaves{};  // in the order of the condition
    bool rests = true;           // the event cannot act
    // Its value below zero at the latest knots.
    double times[3] = {}, below[3] = {};
    int count = 0;
  };

  static bool list_leaves(const Model& model, const Model& placed, const Condition& condition, std::vector<Leaf>& to);
  [[nodiscard]] double calc_value(const Leaf& leaf, const MotionKnot& knot) const;
  void add(Guard& guard, const MotionKnot& knot, bool begins) const;
  // Value of a guard as the kernel has it, at a time about its latest knots; at the latest one for no number.
  [[nodiscard]] double calc(const Guard& guard, double time) const;
  static double calc(const Condition& condition, std::span<const Leaf> leaves, double time, std::size_t& next);
  static bool is_smooth(const Leaf& leaf);
  void find(const Guard& guard);

  const Model& model_;
  std::vector<Guard> guards_;
  std::vector<UnseenCrossing> found_;
};

}  // namespace unlatch::hil
