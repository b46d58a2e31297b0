#include <algorithm>
#include <cmath>

#include "kernel/laws/law_graph.h"
#include "kernel/laws/law_model.h"
#include "kernel/laws/law_steps.h"
#include "unlatch/quantities.h"

namespace unlatch {
namespace {

// Scale, offset and their channels, of a law or a table.
template <class Scaled>
void check_scaling(const Check& check, const Scaled& item) {
  check.check_finite("scale", std::isfinite(item.scale));
  check.check_finite("offset", std::isfinite(item.offset));
  check.check_channel(item.scale_channel);
  check.check_channel(item.offset_channel);
}

// False if the number of values does not follow from it.
bool check_axis(const Check& check, const TableAxis& axis, std::size_t number) {
  const std::string name = "axis " + std::to_string(number + 1) + (axis.name.empty() ? "" : " ('" + axis.name + "')");
  const auto report = [&](const std::string& what, const std::string& mend) {
    check.report("its " + name + what, mend, "axes");
    return false;
  };
  const std::vector<double>& knots = axis.knots;
  if (knots.size() < 2 || knots.size() > kMostTableKnots)
    return report(" has " + std::to_string(knots.size()) + (knots.size() == 1 ? " knot" : " knots"),
                  "2 to " + std::to_string(kMostTableKnots));
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i])) return report(" has a knot that is not finite", "finite knots");
    if (i > 0 && !(knots[i] > knots[i - 1]))
      return report("'s knots do not increase: " + show(knots[i - 1]) + ", " + show(knots[i]),
                    "each knot is larger than the one before");
    if (i > 0 && !std::isfinite(1 / (knots[i] - knots[i - 1])))
      return report(" has knots that are too close to each other: " + show(knots[i - 1]) + ", " + show(knots[i]),
                    "a step whose reciprocal is a number");
  }
  if (!std::isfinite(knots.back() - knots.front())) return report(" is longer than a number", "a finite length");
  return true;
}

void check_values(const Check& check, const Table& table) {
  std::size_t wanted = 1;
  for (std::size_t i = 0; i < table.axes.size(); ++i) {
    if (!check_axis(check, table.axes[i], i)) return;
    wanted *= table.axes[i].knots.size();
    if (wanted > kMostTableValues)
      return check.report("it has more than " + std::to_string(kMostTableValues) + " values", "fewer knots", "axes");
  }
  if (table.values.size() != wanted)
    return check.report("the number of its values is " + std::to_string(table.values.size()),
                        std::to_string(wanted) + ": one per combination of knots", "values");
  for (const double value : table.values)
    if (!std::isfinite(value)) return check.report("it has a value that is not finite", "finite values", "values");
}

// Indices of one step; false if one does not exist.
bool check_step(const Check& check, const LawStep& step) {
  constexpr int kMostPower = 8;
  const Model& model = check.model;
  const auto report = [&](const std::string& what, const std::string& mend) {
    check.report(what, mend, "expression");
    return false;
  };
  switch (step.kind) {
    case LawStep::Kind::kConstant:
      return std::isfinite(step.value) || report("it has a constant that is not finite", "finite constants");
    case LawStep::Kind::kQuantity:
      return is_index(step.subject, model.quantities.size()) ||
             report("a quantity that it reads does not exist", "the index of one quantity");
    case LawStep::Kind::kCommand:
      return is_index(step.subject, model.channels.size()) ||
             report("a channel that it reads does not exist", "the index of one channel");
    case LawStep::Kind::kTable:
      return is_index(step.subject, model.tables.size()) ||
             report("a table that it looks up does not exist", "the index of one table");
    case LawStep::Kind::kPower:
      return std::abs(step.subject) <= kMostPower ||
             report("it has the power " + std::to_string(step.subject), "a whole number from -8 to 8");
    default:
      return static_cast<std::size_t>(step.kind) < std::size(kLawOperands) ||
             report("it has an operation that does not exist", "one of LawStep::Kind");
  }
}

// Every step finds its arguments, and one value is left.
void check_stack(const Check& check, const Law& law) {
  const auto report = [&](const std::string& what, const std::string& mend) { check.report(what, mend, "expression"); };
  if (law.steps.empty()) return report("it has no expression", "at least a number");
  if (law.steps.size() > kMostLawSteps)
    return report("the number of operations of its expression is " + std::to_string(law.steps.size()),
                  "at most " + std::to_string(kMostLawSteps) + ": divide it into several");
  int depth = 0;
  for (const LawStep& step : law.steps) {
    if (!check_step(check, step)) return;
    const int takes = step.kind == LawStep::Kind::kTable
                          ? static_cast<int>(check.model.tables[static_cast<std::size_t>(step.subject)].axes.size())
                          : get_law_arity(step.kind);
    if (depth < takes) return report("a step of its expression lacks arguments", "its arguments before it");
    depth += 1 - takes;
    if (depth > kLawStack)
      return report("it keeps more than " + std::to_string(kLawStack) + " values at once", "divide it into several");
  }
  if (depth != 1) report("the number of values that its expression leaves is " + std::to_string(depth), "one value");
}

// What forces read must be known before the forces.
void check_readable(const Model& model, const LawGraph& graph, ModelErrors& errors) {
  for (std::size_t i = 0; i < model.laws.size(); ++i) {
    if (!graph.driving[i]) continue;
    for (const LawStep& step : model.laws[i].steps) {
      if (step.kind != LawStep::Kind::kQuantity) continue;
      const Quantity& quantity = model.quantities[static_cast<std::size_t>(step.subject)];
      if ((get_traits(quantity.kind).reads & kReadsMultipliers) == 0) continue;
      errors.push_back({quoted("law", model.laws[i].name),
                        "a force reads it, and it reads '" + std::string(get_traits(quantity.kind).name) +
                            "', which follows from the forces",
                        "read positions, velocities, times or commands; accelerations, reactions and forces of "
                        "elements are known only once all forces are",
                        "expression"});
    }
  }
}

void validate_tables(const Model& model, ModelErrors& errors) {
  for (const Table& table : model.tables) {
    const Check check{model, quoted("table", table.name), errors};
    if (table.axes.empty() || table.axes.size() > kMostTableAxes)
      check.report("the number of its axes is " + std::to_string(table.axes.size()),
                   "1 to " + std::to_string(kMostTableAxes), "axes");
    else
      check_values(check, table);
    check_scaling(check, table);
  }
}

}  // namespace

int get_law_arity(LawStep::Kind kind) { return get_operands(kind).takes; }

void validate_laws(const Model& model, ModelErrors& errors) {
  validate_tables(model, errors);
  if (!errors.empty()) return;
  for (const Law& law : model.laws) {
    const Check check{model, quoted("law", law.name), errors};
    check_stack(check, law);
    check_scaling(check, law);
  }
  if (!errors.empty()) return;  // indices do not hold
  const LawGraph graph = build_law_graph(model);
  for (const int law : graph.circle)
    errors.push_back({quoted("law", model.laws[static_cast<std::size_t>(law)].name),
                      "it depends on itself, through the laws that it reads", "leave one of these references out",
                      "expression"});
  if (graph.circle.empty()) check_readable(model, graph, errors);
}

}  // namespace unlatch
