// Audit of the step: some steps of a run are taken again as two of half the length, and the difference is the error
// that the step makes in each body's motion. (E. Hairer, Nørsett, Wanner: Solving Ordinary Differential Equations I,
// II.4: the difference is the error of the longer step, but for that of the shorter ones.)
//
// Which steps: in each block of kBlock ticks one, at a place drawn from the number of the block alone; after the start,
// after events and after a step in which an acceleration jumps more: the first, and those 1, 2, 4 … kBlock / 2 later,
// as long as there are not too many. As long as all errors are small (kCalm), three of four blocks have none. So of a
// long run 1/512 + 1/256 of the steps are taken twice (1/128 + 1/256 with larger errors), and a dozen at its start.
// Between two of them a tick counts as wrong by the lesser of their errors; so a rare error, such as that of a jump
// within one step, counts once.
//
// The sum of the errors, by their size, is an estimate of what the steps make of a body's motion. It is compared with
// what the body's own motion has changed since the start, by itself and relative to the centre of mass of all bodies,
// so that neither a faster body nor a common flight hides anything. Beyond kLimit of it the motion is not resolved.
//
// Steps are compared only where both see the same events. Cost: some multiplications for each body and tick, and the
// steps that are taken again; off the cyclic thread. Deterministic: a function of the run alone.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "hil/run/simulation/simulation.h"
#include "unlatch/plan/halved_plan.h"

namespace unlatch::hil {

// Parts of a body's motion that are judged; the own ones are relative to the centre of mass of all bodies.
enum class MotionPart { kPlace, kVelocity, kOwnPlace, kOwnVelocity, kAttitude, kRate };
inline constexpr int kMotionParts = 6;

// What the steps did to a part of a body's motion, in SI units.
struct StepError {
  int body = kNone;
  MotionPart part = MotionPart::kVelocity;
  double error = 0;       // estimated, of the run so far
  double change = 1;      // largest change of this part since the start
  double time = kNever;   // s, since when it is beyond the limit
  double from = kNever;   // s, the step before that was compared: the error came up between the two
  double until = kNever;  // s, until when, if it is no more
  static constexpr double kNever = std::numeric_limits<double>::infinity();
};

class StepAudit {
 public:
  static constexpr std::int64_t kBlock = 128;  // ticks
  // Part of the change that an error may be. Of an oscillation the estimate is a third to a fifth of the error of its
  // phase: its velocity changes by twice its amplitude, only a part of the error lies along it, and of two neighbours
  // the lesser counts. So results are off by some tenth at this limit.
  static constexpr double kLimit = 0.02;
  static constexpr double kPhase = 8;  // times the estimate: what results are off by at most
  static constexpr double kCalm = kLimit / 64;
  static constexpr std::int64_t kCalmEvery = 4;  // blocks

  // Keeps a reference.
  explicit StepAudit(const Simulation& simulation);

  // A step that was taken again: the second half's end, and the ticks since the one before.
  struct Repeated {
    const Plan& plan;
    const State& state;
    const Workspace& workspace;
    double between = 0;
  };

  // Called after the initial state (a default report), and after each step. The step if it was taken again.
  std::optional<Repeated> update(const StepReport& report);

  // Adds errors that the latest step made in a body's motion, found by other means, where they are larger than what its
  // halves showed, if it was taken again. `rate`: of the feedback that made them, 1/s.
  void add_feedback(int body, const std::array<double, kMotionParts>& errors, double rate);
  // The largest such rate of a body so far, 1/s; 0: none.
  [[nodiscard]] double get_feedback(int body) const { return courses_[static_cast<std::size_t>(body)].feedback; }

  // Bodies whose motion the step does not resolve, each with the part that is worst.
  [[nodiscard]] std::vector<StepError> list_unresolved() const;
  // Bodies that were not resolved for a while, and have moved so much more since that they are: values of that while
  // are not.
  [[nodiscard]] std::vector<StepError> list_passed() const;
  // Of each body whose error is more than this part of what its motion has changed, the part that is worst.
  [[nodiscard]] std::vector<StepError> list_errors(double part) const;
  // Errors of the steps in a body's motion until a time, s, and what its parts had changed by then.
  struct BodyErrors {
    std::array<double, kMotionParts> error{}, change{};
  };
  [[nodiscard]] BodyErrors get_errors(int body, double until) const;
  // Steps that were taken again, of all so far.
  [[nodiscard]] std::int64_t get_compared() const { return compared_; }
  [[nodiscard]] std::int64_t get_ticks() const { return ticks_; }
  // The largest estimated error, relative to what the part of the motion has changed.
  [[nodiscard]] StepError find_worst() const;

 private:
  static constexpr double kNever = StepError::kNever;
  static constexpr std::array<double, kMotionParts> make_never() {
    std::array<double, kMotionParts> never{};
    never.fill(kNever);
    return never;
  }
  struct Centre {
    Vec3 p, v;
  };
  // A velocity at the latest tick, and its change by the latest step.
  struct Pace {
    Vec3 latest{0, 0, 0}, change{0, 0, 0};
    // Moves on to the next tick, and returns how much the change has changed.
    Vec3 move(const Vec3& value) {
      const Vec3 by = value - latest, jump = by - change;
      latest = value;
      change = by;
      return jump;
    }
  };
  // The errors by a step that was taken again, kept where one of them had grown by kGrowth since the mark before.
  struct Mark {
    double time = 0;  // s, the end of that step
    BodyErrors errors;
  };
  static constexpr double kGrowth = 1.25;
  // What a body's motion has changed, and the errors of its steps.
  struct Course {
    BodyState start;
    Pace v, w;
    std::array<double, kMotionParts> squared_change{}, error{}, latest{}, since = make_never(), from = make_never();
    double feedback = 0;        // 1/s: the largest rate of one that a step did not resolve
    StepError passed{};         // `until` is kNever if there was none
    std::vector<Mark> marks{};  // in their order
    [[nodiscard]] double get_change(std::size_t part) const;  // at least that of a body at rest
  };
  // Plan of half the step, and memory to step with it.
  struct Half {
    explicit Half(const Plan& whole);
    Plan plan;
    std::vector<std::uint64_t> block;
    std::vector<std::byte> memory;
    State state;
    Workspace workspace;
  };

  void begin();
  [[nodiscard]] Centre calc_centre(const State& state) const;
  // Moves the courses on by the latest step. True where some acceleration jumped.
  bool follow();
  void measure(Course& course, const BodyState& now, const Centre& centre) const;
  bool follow(Course& course, const BodyState& now, const Vec3& common) const;
  // True if the step that began at this tick is to be taken again.
  bool is_due(std::int64_t tick, bool special);
  // Takes the latest step again. False where the two do not see the same events.
  bool repeat(const StepReport& report);
  double compare(std::int64_t tick);
  void add_error(Course& course, const std::array<double, kMotionParts>& errors, double between);
  void judge(Course& course, double between);
  void add_passed(Course& course, std::size_t part) const;
  void mark(Course& course) const;
  [[nodiscard]] static BodyErrors get_errors(const Course& course);
  [[nodiscard]] StepError find_worst(int body) const;
  [[nodiscard]] const State& find_before() const;
  void keep();

  const Simulation& simulation_;
  std::vector<double> masses_;  // of bodies, in parts of the whole
  Centre start_{};              // the centre at the start
  Pace centre_;
  std::vector<Course> courses_;  // of bodies
  Half half_;
  std::vector<std::uint64_t> block_;  // the state before the latest step, where no motion is kept
  State before_;
  bool begun_ = false, calm_ = true;
  std::int64_t ticks_ = 0, compared_ = 0, extra_ = 0;
  std::int64_t origin_ = 0;      // the start, or the latest event or jump
  std::int64_t latest_ = kNone;  // tick of the latest step that was compared
};

}  // namespace unlatch::hil
