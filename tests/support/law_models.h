// Small models with laws and tables: a ball that a law pushes, tables of functions.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_models.h"
#include "unlatch/model.h"

namespace unlatch::test::laws {

using Kind = LawStep::Kind;

inline LawStep constant(double value) { return {Kind::kConstant, 0, value}; }
inline LawStep quantity(int number) { return {Kind::kQuantity, number, 0}; }
inline LawStep step_of(Kind kind, int subject = 0) { return {kind, subject, 0}; }

inline Law law_of(std::vector<LawStep> steps, const std::string& name = "law") {
  Law law;
  law.name = name;
  law.steps = std::move(steps);
  return law;
}

inline Quantity along_x(Quantity::Kind kind, const std::string& name) {
  Quantity quantity;
  quantity.name = name;
  quantity.kind = kind;
  quantity.other = kGround;
  quantity.part = 0;
  return quantity;
}

inline Load load_by(int law, Load::Frame frame = Load::Frame::kWorld) {
  Load load;
  load.name = "push";
  load.frame = frame;
  load.profile.kind = Profile::Kind::kLaw;
  load.profile.law = law;
  return load;
}

// A ball of 2 kg with the position x as quantity 0, pushed along x by law 0.
inline Model build_pushed(std::vector<LawStep> steps) {
  Model model;
  model.bodies.push_back(box("ball", 2, 1, 1, 1));
  model.quantities.push_back(along_x(Quantity::Kind::kPosition, "x"));
  model.laws.push_back(law_of(std::move(steps)));
  model.loads.push_back(load_by(0));
  return model;
}

inline Table table_of(std::vector<std::vector<double>> axes, const auto& value) {
  Table table;
  table.name = "table";
  std::size_t count = 1;
  for (const std::vector<double>& knots : axes) {
    table.axes.push_back({.name = "axis", .knots = knots});
    count *= knots.size();
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> at(axes.size());
    std::size_t rest = i;
    for (std::size_t a = axes.size(); a-- > 0; rest /= axes[a].size()) at[a] = axes[a][rest % axes[a].size()];
    table.values.push_back(value(at));
  }
  return table;
}

// The time, as a quantity.
inline Quantity time_of() {
  Quantity time;
  time.name = "time";
  return time;
}

}  // namespace unlatch::test::laws
