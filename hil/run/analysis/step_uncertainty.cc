#include "hil/run/analysis/step_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "hil/run/audit/dependence.h"
#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

using Measure = Requirement::Measure;

// Of the motion: less is no reason for doubt.
constexpr double kLeast = 1e-7;
// Times the estimate of the audit: of an oscillation that is a fifth to a third of what the motion is off by
// (kernel/THEORY.md, 9).
constexpr double kOfPhase = 5;

// Parts of a motion: the whole one, or that relative to the centre of mass of all bodies.
struct Parts {
  MotionPart place, velocity;
};
constexpr Parts kWhole{MotionPart::kPlace, MotionPart::kVelocity};
constexpr Parts kOwn{MotionPart::kOwnPlace, MotionPart::kOwnVelocity};
constexpr Parts kTurning{MotionPart::kAttitude, MotionPart::kRate};

double get_relative(const StepAudit::BodyErrors& errors, MotionPart part) {
  const std::size_t i = at(static_cast<int>(part));
  return errors.error[i] / errors.change[i];
}
double get_relative(const StepAudit::BodyErrors& errors, const Parts& parts) {
  return std::max(get_relative(errors, parts.place), get_relative(errors, parts.velocity));
}
double get_change(const StepAudit::BodyErrors& errors, MotionPart part) {
  return errors.change[at(static_cast<int>(part))];
}

// Whether it is a place, a velocity, an angle or a rate of bodies.
struct MeasuredPart {
  bool of_motion = false, turns = false, is_rate = false;
};
MeasuredPart get_measured_part(const Model& model, const Requirement& requirement) {
  if (requirement.quantity == Measure::kQuantity) {
    const SubjectOf of = get_traits(model.quantities[at(requirement.a)].kind).of;
    if (of != SubjectOf::kBody && of != SubjectOf::kJoint) return {};
    const std::string& unit = requirement.unit;
    const bool is_rate = unit == "m/s" || unit == "rad/s", turns = unit == "rad" || unit == "rad/s";
    return {.of_motion = is_rate || turns || unit == "m", .turns = turns, .is_rate = is_rate};
  }
  switch (requirement.quantity) {
    case Measure::kClearance:
    case Measure::kPosition:
      return {.of_motion = true};
    case Measure::kVelocity:
      return {.of_motion = true, .is_rate = true};
    case Measure::kDisplacement:
    case Measure::kAngle:
      return {.of_motion = true, .turns = requirement.axis >= kRotX};
    case Measure::kSpeed:
      return {.of_motion = true, .turns = requirement.axis >= kRotX, .is_rate = true};
    case Measure::kAxes:
      return {.of_motion = true, .turns = true};
    case Measure::kRate:
      return {.of_motion = true, .turns = true, .is_rate = true};
    default:
      return {};
  }
}

}  // namespace

double calc_step_uncertainty(const Model& model, const Requirement& requirement, double value, double until,
                             const StepAudit& audit) {
  const MeasuredPart part = get_measured_part(model, requirement);
  const std::vector<int> bodies = list_own_bodies(model, requirement);
  const Parts along = bodies.size() > 1 ? kOwn : kWhole;
  double sum = 0, largest = 0;
  for (const int body : bodies) {
    const StepAudit::BodyErrors errors = audit.get_errors(find_carrier(model, body), until);
    const double linear = get_relative(errors, along), angular = get_relative(errors, kTurning);
    if (part.of_motion)
      largest = std::max(largest, part.turns ? angular : linear);
    else
      largest = std::max({largest, linear, angular});
    if (part.turns)
      sum += angular * get_change(errors, part.is_rate ? kTurning.velocity : kTurning.place);
    else
      sum += linear * get_change(errors, part.is_rate ? along.velocity : along.place);
  }
  if (largest < kLeast) return 0;
  return kOfPhase * (part.of_motion ? sum : largest * std::abs(value));
}

}  // namespace unlatch::hil
