// LawWatch: what laws that forces read do between the instants at which a step evaluates them.
//
// A step sees a force at its beginning, in its middle and at its end, and weighs it there by 1/6, 4/6, 1/6. A pulse
// that is over before the middle, or a jump that is not written with `if_less`, acts on no stage, or on some by chance.
// After the step the bounds of each law over it (LawCourses) show if some function in it may do so. If one may,
// the step is bisected until they show no more, down to 1/4096 of it; the integral is then that of the law, and is
// compared with the one that the stages took. Quantities that the law reads follow, between the ticks, the parabola
// through the latest three.
//
// Cost: per step three evaluations of each law with its bounds; some hundred where a law may hide something.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "unlatch/model.h"
#include "unlatch/model/law_courses.h"
#include "unlatch/model/law_places.h"
#include "unlatch/motion.h"
#include "unlatch/plan.h"

namespace unlatch::hil {

// Error of the integral of a law over a step, relative to the step's length and the law's largest value so far, beyond
// which the step does not resolve the law; likewise of its jumps.
inline constexpr double kLawError = 1e-3;

// What a step passed over.
struct PassedOver {
  int law = 0;                  // index of the model
  double time = 0, value = 0;   // where the law is farthest from the line between its values at both ends, s
  double error = 0;             // as kLawError
  double step = 0;              // s, that would see it; 0: none would, the law jumps, or all but jumps
  std::span<const int> bodies;  // that forces by this law push
};

class LawWatch {
 public:
  // kOfTime: laws of time alone, for which the time since an element was switched on counts as the time of the run.
  // Their pieces are whole steps: those that a run splits are passed over here.
  enum class Laws { kAll, kOfTime };
  // Keeps references to both.
  LawWatch(const Model& model, const Plan& plan, Laws laws = Laws::kAll);

  // Of a step with these knots and commands. Valid until the next call.
  std::span<const PassedOver> update(std::span<const MotionKnot> knots, std::span<const double> commands);

  // A time within which the step was not split, and the model's quantities at both ends.
  struct Piece {
    double from = 0, to = 0;  // s
    std::span<const double> at_from, at_to;
  };
  // Of one piece; it may continue the one before.
  std::span<const PassedOver> update(const Piece& piece, std::span<const double> commands);

  // Laws that rise steeply until the end of the latest piece, as if they had ceased to: what a run passes over in its
  // last step. Those that go on are judged when they cease.
  [[nodiscard]] std::vector<PassedOver> list_rising() const;

  [[nodiscard]] bool is_empty() const { return watched_.empty(); }

 private:
  static constexpr int kMostEvaluations = 600, kFewestEvaluations = 15;  // of a law in a step
  struct Overview {
    Course course;
    double hidden = 0;
    LawCourses::Marks marks;
  };
  struct Watched {
    int law;
    std::vector<int> behind;  // laws that it reads, and itself
    std::vector<int> bodies;
    double largest = 0;  // of its size so far
    double seen = 0;     // of that at the instants that the steps saw
    int evaluations = kMostEvaluations;
    Overview whole;                    // of the latest piece
    std::optional<PassedOver> rising;  // see judge(); its error has the law's unit
    bool rises_smoothly = false;       // measure_rise() has found it: its step is the piece
  };
  // A quantity over the piece: begin + s (end − begin) + bend s (s − 1), s from 0 to 1.
  struct Path {
    int quantity;
    double begin = 0, end = 0, bend = 0;
    double before = 0;  // at the beginning of the piece before
    bool is_angle = false;
  };
  struct Sample {
    double part, value;
  };
  // The integral of a law over a part of the piece, and what is found there.
  struct Look {
    double integral = 0, jump = 0;
    double size = 0;  // of the law, by its bounds
    int left = 0;     // evaluations that may still be done
    std::vector<Sample> samples;
  };

  bool follow(const Piece& piece);
  void set_quantities(double from, double to);
  void look_at_all();
  const Course& calc(const Watched& watched, double from, double to,
                     LawCourses::Sides sides = LawCourses::Sides::kDecide);
  void look_at(const Watched& watched, double from, double to, int depth);
  std::optional<PassedOver> measure(Watched& watched, const Piece& piece);
  [[nodiscard]] PassedOver measure_rise(const Watched& watched, const Piece& piece);
  void judge(Watched& watched, const Piece& piece);
  [[nodiscard]] static PassedOver finish_rise(const Watched& watched);
  void report(const Watched& watched, PassedOver passed);
  void set_extreme(const Watched& watched, const Piece& piece, PassedOver& passed);
  [[nodiscard]] double find_step(const Watched& watched, double top, double width);

  const Laws laws_;
  const double dt_;
  LawCourses courses_;
  std::vector<Watched> watched_;
  std::vector<int> behind_;         // laws behind any of them, each behind those that it reads
  std::vector<Path> paths_;         // of the quantities that they read
  std::vector<Course> quantities_;  // the model's
  std::span<const double> commands_;
  double from_ = 0, to_ = 0;  // the latest piece, s
  bool begun_ = false;
  Look look_;
  std::vector<PassedOver> passed_;
};

}  // namespace unlatch::hil
