// Laws over a short time, of which a step sees some instants only: values there, and bounds of what lies between. They
// show what a step passes over, such as a pulse that is shorter. Off the step: it allocates, and costs some three times
// the evaluation of a law.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "unlatch/model.h"
#include "unlatch/plan.h"

namespace unlatch {

struct PlanLawStep;  // kernel/plan/plan_laws.h

// A number over a short time: at its beginning, in its middle and at its end; and bounds of it in between.
struct Course {
  double begin = 0, middle = 0, end = 0, low = 0, high = 0;

  // That of the parabola through these three, with its own bounds.
  static Course of_parabola(double begin, double middle, double end) noexcept;
};

// Courses of the laws of a plan.
class LawCourses {
 public:
  // Keeps references to both.
  LawCourses(const Model& model, const Plan& plan);

  // Which sides the laws' `if_less` take: their own, or all along those that the middle of the latest course with
  // kDecide took, as the stages of a step do.
  enum class Sides { kDecide, kHold };
  // Computes these laws, each behind those that it reads. `quantities`: the model's.
  void update(std::span<const int> laws, std::span<const double> commands, std::span<const Course> quantities,
              Sides sides = Sides::kDecide);

  // As updated. Bounds that an expression does not have, as of a division by what passes zero, are infinite.
  [[nodiscard]] const Course& get(int law) const { return seen_[static_cast<std::size_t>(law)].whole; }
  // What the course of a law shows.
  struct Marks {
    // The way of some argument is long for the function that it is put into, so that this may rise and fall in between;
    // such as that of exp() over more than 1.
    bool sharp = false;
    // It passes a corner that the three instants show: a step would be split there.
    bool split = false;
  };
  // As updated.
  [[nodiscard]] const Marks& get_marks(int law) const { return seen_[static_cast<std::size_t>(law)].marks; }
  // How much lower and higher the law may be than with sharp functions as they are at the three instants, at most.
  [[nodiscard]] double get_hidden(int law) const { return seen_[static_cast<std::size_t>(law)].hidden; }

 private:
  struct Seen {
    Course whole;  // with the bounds of sharp functions
    Course plain;  // with those functions as they are at the three instants
    Marks marks;
    double hidden = 0;
  };
  enum class Bounds { kWhole, kPlain };
  struct Context;
  [[nodiscard]] Course calc(const Context& context, int law, Bounds bounds, Marks& marks);
  [[nodiscard]] Course look_up(const Context& context, const PlanLawStep& step, const Course* coordinates,
                               Bounds bounds, Marks& marks);
  [[nodiscard]] Course find(const Context& context, const PlanLawStep& step, const Course* coordinates);

  const Plan& plan_;
  std::vector<Seen> seen_;                   // by law
  std::vector<std::int8_t> sides_;           // by place: the side in the middle
  std::vector<Course> coordinates_, found_;  // by place: the latest look-up there, and at its first place what it found
  std::vector<std::pair<double, double>> of_tables_;  // bounds of their values, by table
};

}  // namespace unlatch
