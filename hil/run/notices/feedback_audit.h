// Audit of forces that depend on the motion that they cause: laws and tables over speeds and places, drag, springs,
// pushers. The audit of the step (audit/step_audit.h) compares a step with its halves, and is deceived where all of
// them end their first part at one knot of a table: then they make the same error. This one takes the derivative of the
// forces instead, along the motion that was flown.
//
// A step of length h makes of y' = f(y), with the derivative J of f, an error of which h⁵ J⁴ f / 120 is a part, and the
// only one where f is linear (E. Hairer, Nørsett, Wanner: Solving Ordinary Differential Equations I, II.2). J⁴ f is
// taken by four differences of accelerations, one after the other, in the middle between two knots of the motion, where
// a table's slope is that of the cell that was passed; h is the time between the knots. |h⁴ J⁴ f| / |f| to the power of
// 1/4 is h times the rate of the feedback. Up to kUnresolvedSize nothing is doubted, nor up to kResolved in a step that
// was not split: of that its halves tell the error.
//
// Where: where an acceleration changed, from knot to knot, by more than kUnresolvedSize of what the rate of that change
// would make of the velocity, or of the place. At most kFirst pieces of motion, and one for each kEvery ticks. Left out
// are bodies that are joined to others by joints among which a spring or a mode is integrated implicitly, or a contact
// is closed: their steps have other errors, and audits of their own.
//
// Cost: a few multiplications for each body and piece; for a piece that is looked at, five evaluations.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hil/run/audit/step_audit.h"
#include "hil/run/simulation/simulation.h"
#include "unlatch/frequencies.h"

namespace unlatch::hil {

// What a step made of the motion of a body by a feedback that it does not resolve.
struct FeedbackError {
  int body = kNone;
  double rate = 0;                           // of the feedback, 1/s
  std::array<double, kMotionParts> error{};  // in SI units
};

class FeedbackAudit {
 public:
  // Keeps a reference.
  explicit FeedbackAudit(const Simulation& simulation);

  // Springs, in the modes of the joints from now on.
  void set_rates(std::span<const ElementFrequency> frequencies);
  // Called after each step of a simulation that keeps its motion. `workspace` loses its outputs.
  std::span<const FeedbackError> update(Workspace& workspace);

 private:
  static constexpr std::int64_t kFirst = 64, kEvery = 32;
  // A small motion of a body, world axes: of its place and its attitude, and of its velocities.
  struct Change {
    Spatial place{{0, 0, 0}, {0, 0, 0}}, velocity{{0, 0, 0}, {0, 0, 0}};
  };
  // What a body has changed since the start, and how it changed from one knot to the next.
  struct Course {
    Vec3 v{0, 0, 0}, w{0, 0, 0};    // at the start
    double most_v = 0, most_w = 0;  // largest changes since, m/s, rad/s
    // In the piece: of place and attitude, and of velocities, world axes.
    Spatial moved{{0, 0, 0}, {0, 0, 0}}, by{{0, 0, 0}, {0, 0, 0}};
    bool suspect = false;
  };

  [[nodiscard]] bool suspect(const MotionKnot& from, const MotionKnot& to);
  void measure(const MotionKnot& from, const MotionKnot& to, Workspace& workspace);
  [[nodiscard]] bool apply(double part, Workspace& workspace);
  [[nodiscard]] double find_part() const;
  void list_left_out();
  void set_middle(const MotionKnot& from, const MotionKnot& to);
  [[nodiscard]] FeedbackError judge(std::size_t body, double time) const;
  void add(const FeedbackError& error);

  const Simulation& simulation_;
  std::vector<Course> courses_;         // of bodies
  std::vector<Change> changes_;         // of bodies: the present power of h J times h f
  std::vector<Change> taken_, first_;   // its powers 0 and 1
  std::vector<Spatial> accelerations_;  // in the middle
  std::vector<int> implicit_;           // springs that are integrated implicitly
  std::vector<bool> modal_, left_out_;  // bodies
  std::vector<std::uint64_t> block_, middle_block_;
  State state_, middle_;
  std::vector<FeedbackError> errors_;
  std::int64_t ticks_ = 0, looks_ = 0;
};

}  // namespace unlatch::hil
