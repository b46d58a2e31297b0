#include "hil/scenario/requirements_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/scenario/base/index.h"
#include "hil/scenario/earliest.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

using Measure = Requirement::Measure;

bool holds(const Requirement& requirement, const Model& model) {
  const RowSet rows = list_held_rows(model.joints[static_cast<std::size_t>(requirement.a)]);
  if (requirement.axis >= 0) return has_row(rows, requirement.axis);
  return (rows & (requirement.axis == Requirement::kForce ? kPointRows : kRotationRows)) != 0;
}

}  // namespace

std::vector<RequirementProblem> find_problems(const Scenario& scenario) {
  std::vector<RequirementProblem> problems;
  const EarliestTimes earliest(scenario.model);
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i) {
    const Requirement& requirement = scenario.requirements[i];
    std::vector<const EventName*> names{&requirement.at, &requirement.from, &requirement.to};
    for (const EventName& name : requirement.events) names.push_back(&name);
    for (const EventName* name : names) {
      if (!name->is_named()) continue;
      if (name->event == kNone) {
        problems.push_back({i, "event '" + name->text + "' is left out", "enable it, or leave out the requirement"});
        continue;
      }
      if (const std::string why = earliest.explain(at(name->event), scenario.until); !why.empty())
        problems.push_back({i, "event '" + name->text + "' " + why, "run longer, or name an event within the run"});
    }
    if (requirement.from.is_named() && requirement.from.text == requirement.to.text)
      problems.push_back({i, "its interval begins and ends with the same event", "name two events"});
    if (requirement.quantity == Requirement::Measure::kReaction && !holds(requirement, scenario.model))
      problems.push_back(
          {i, "no mode of its joint holds this row: the reaction is 0", "name a row that some mode holds"});
  }
  return problems;
}

namespace {

// Returns true if the value is never below 0. A signed clearance may be below 0, and so may the time between two
// events.
bool is_size(const Requirement& requirement, const Model& model) {
  if (requirement.take == Requirement::Take::kPeak) return true;
  switch (requirement.quantity) {
    case Measure::kRate:
    case Measure::kAxes:
      return true;
    case Measure::kTime:
      return requirement.events.size() == 1;
    case Measure::kReaction:
    case Measure::kSensor:
      return requirement.axis < 0;
    case Measure::kVelocity:
    case Measure::kPosition:
      return requirement.direction.isZero(0);
    case Measure::kQuantity: {
      const unlatch::Quantity& quantity = model.quantities[static_cast<std::size_t>(requirement.a)];
      return quantity.part == unlatch::Quantity::kSize && quantity.direction.isZero(0) &&
             count_values(get_traits(quantity.kind)) > 1;
    }
    default:
      return false;
  }
}

// The pusher, stop or cord whose force, with its sign, a requirement is on; null: none.
const OneSided* find_signed_force(const Requirement& requirement, const Model& model) {
  if (requirement.quantity != Measure::kQuantity || requirement.take == Requirement::Take::kPeak) return nullptr;
  const unlatch::Quantity& quantity = model.quantities[at(requirement.a)];
  if (quantity.kind != unlatch::Quantity::Kind::kForce) return nullptr;
  const int number = quantity.subject - get_first_one_sided(model);
  return number >= 0 && at(number) < model.one_sided.size() ? &model.one_sided[at(number)] : nullptr;
}

}  // namespace

std::vector<RequirementProblem> find_trivial(const Scenario& scenario) {
  constexpr double kPi = 3.14159265358979323846;
  std::vector<RequirementProblem> found;
  for (std::size_t i = 0; i < scenario.requirements.size(); ++i) {
    const Requirement& requirement = scenario.requirements[i];
    const double greatest =
        requirement.quantity == Requirement::Measure::kAxes ? kPi : std::numeric_limits<double>::infinity();
    if (is_size(requirement, scenario.model) && requirement.least <= 0 && requirement.most >= greatest)
      found.push_back({i,
                       greatest == kPi ? "holds in every run: the angle between two axes is from 0 to pi"
                                       : "holds in every run: the value is never below 0",
                       "give a limit that a run can miss"});
    const OneSided* const force = find_signed_force(requirement, scenario.model);
    const bool never_above = force != nullptr && force->pulls && requirement.most >= 0 && std::isinf(requirement.least);
    const bool never_below =
        force != nullptr && !force->pulls && requirement.least <= 0 && std::isinf(requirement.most);
    if (never_above || never_below)
      found.push_back({i,
                       "holds in every run: the force of '" + force->name + "' has the sign of what it does to its " +
                           "coordinate, and is never " + (never_above ? "above" : "below") + " 0",
                       "give `take: peak` for its size, or a limit that a run can miss"});
  }
  return found;
}

}  // namespace unlatch::hil
