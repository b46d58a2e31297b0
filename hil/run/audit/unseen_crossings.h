// Events whose instants no knot shows: between two knots a condition on quantities became true, and false again, so
// that the event did not act. Guards are known at knots alone; between them the quantities are the polynomials through
// the latest five knots of a smooth run, of the size of a vector those of its square; of times alone they are known.
// Distances of shapes have their
// own search (unseen_clearances.h), and so have engagements (unseen_engagements.h). Conditions that read what no knot
// has, such as forces of pushers and windings of cords, are not searched: list_unsearched() names them. Nor are
// quantities that change too abruptly from knot to knot for a polynomial. Cost: some quantities for each event that
// compares any, and knot.
#pragma once

#include <optional>
#include <span>
#include <string>
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

// The condition of a repeating event has become true again while its delay ran: it does not act for that.
struct LostTrigger {
  int event = 0;    // index in the model
  double time = 0;  // s, of the knot at which it was true again
};

// An event whose condition may hold within a step alone and is not searched for that.
struct UnsearchedEvent {
  int event = 0;      // index in the model
  std::string reads;  // what no knot has: "force of pusher1"
};
std::vector<UnsearchedEvent> list_unsearched(const Model& model);

class UnseenCrossings {
 public:
  // Keeps a reference.
  explicit UnseenCrossings(const Model& model);

  // Of the piece between these knots, to which the window has moved, and the one before it. Valid until the next call.
  // `commands`: in that piece.
  std::span<const UnseenCrossing> find(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to,
                                       std::span<const double> commands);

  // Likewise of repeating events with delays, as far as knots show their conditions.
  std::span<const LostTrigger> find_lost(const MotionKnot& from, const MotionKnot& to,
                                         std::span<const double> commands);

 private:
  // A condition without parts: its quantity at the latest knots, or true or false.
  struct Leaf {
    Condition condition;
    std::optional<JointGeometry> joint{};
    bool squared = false;  // the values are squares
    bool holds = false;    // of one that changes by events alone, or at ticks
    SampledCurve curve{};
  };
  struct Guard {
    int event = 0;
    bool repeats = false;
    std::vector<Leaf> leaves{};  // in the order of the condition
    bool rests = true;           // the event cannot act
    bool spans = false;          // of times, and of what changes by events or at ticks, alone
    // Its value below zero at the latest knots.
    double times[3] = {}, below[3] = {};
    int count = 0;
  };

  static bool list_leaves(const Model& model, const Model& placed, const Condition& condition, std::vector<Leaf>& to);
  // At a knot: a number, its square, or kYes or kNo of what changes by events alone or at ticks.
  [[nodiscard]] double read(const Leaf& leaf, const MotionKnot& knot, std::span<const double> commands) const;
  void add(Guard& guard, const MotionKnot& knot, std::span<const double> commands, bool begins) const;
  // Value of a guard as the kernel has it, at a time about its latest knots; at the latest one for no number.
  [[nodiscard]] double calc(const Guard& guard, double time) const;
  static double calc(const Condition& condition, std::span<const Leaf> leaves, double time, std::size_t& next);
  static bool is_smooth(const Leaf& leaf);
  void find(const Guard& guard);
  void find_span(const Guard& guard);

  // The condition of a repeating event with a delay.
  struct Delayed {
    Guard guard;
    bool was_false = false;  // since its delay began
  };
  const Model& model_;
  std::vector<Guard> guards_;
  std::vector<Delayed> delayed_;
  std::vector<UnseenCrossing> found_;
  std::vector<LostTrigger> lost_;
};

}  // namespace unlatch::hil
