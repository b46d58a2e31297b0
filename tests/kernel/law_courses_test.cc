// Laws over a short time: their bounds hold what the laws are in between, for random expressions.
#include "unlatch/model/law_courses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kernel/math/index.h"
#include "tests/support/random.h"
#include "tests/support/simulation.h"
#include "tests/support/small_models.h"

namespace unlatch::test::law_courses_test {
namespace {

using Kind = LawStep::Kind;

constexpr double kRounding = 1e-12;  // relative

LawStep step_of(Kind kind, int subject = 0) { return {kind, subject, 0}; }
LawStep constant(double value) { return {Kind::kConstant, 0, value}; }

// Draws an expression over two quantities, as steps in postfix order.
void draw(Random& random, int depth, std::vector<LawStep>& steps) {
  constexpr Kind kOne[] = {Kind::kNegate, Kind::kSqrt, Kind::kAbs,  Kind::kSin, Kind::kCos, Kind::kTan,
                           Kind::kAsin,   Kind::kAcos, Kind::kAtan, Kind::kExp, Kind::kLog};
  constexpr Kind kTwo[] = {Kind::kAdd,   Kind::kSubtract, Kind::kMultiply, Kind::kDivide,
                           Kind::kAtan2, Kind::kMin,      Kind::kMax};
  const double kind = random.uniform(0, 1);
  if (depth == 0 || kind < 0.15) {
    steps.push_back(random.chance(0.3) ? constant(random.uniform(-3, 3))
                                       : step_of(Kind::kQuantity, random.chance(0.5) ? 0 : 1));
  } else if (kind < 0.45) {
    draw(random, depth - 1, steps);
    const int which = static_cast<int>(random.uniform(0, 12));
    steps.push_back(which == 11 ? step_of(Kind::kPower, static_cast<int>(random.uniform(-4, 5)))
                                : step_of(kOne[which]));
  } else if (kind < 0.9) {
    draw(random, depth - 1, steps);
    draw(random, depth - 1, steps);
    steps.push_back(step_of(kTwo[static_cast<int>(random.uniform(0, 7))]));
  } else {
    for (int i = 0; i < 4; ++i) draw(random, depth - 1, steps);
    steps.push_back(step_of(Kind::kIfLess));
  }
}

Model build(std::vector<LawStep> steps) {
  Model model;
  model.name = "law";
  model.bodies = {box("ball", 1, 1, 1, 1)};
  for (int part : {0, 1}) {
    Quantity& q = model.quantities.emplace_back();
    q.name = part == 0 ? "x" : "y";
    q.kind = Quantity::Kind::kPosition;
    q.part = part;
  }
  Law& law = model.laws.emplace_back();
  law.name = "law";
  law.steps = std::move(steps);
  return model;
}

Course make_point(double value) { return {value, value, value, value, value}; }

TEST(LawCourses, HoldWhatTheLawIsInBetween) {
  constexpr unsigned kSeed = 20261127;
  RecordProperty("seed", kSeed);
  Random random(kSeed);
  int judged = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<LawStep> steps;
    draw(random, 4, steps);
    const Model model = build(steps);
    const PlanResult compiled = compile_plan(model, {.dt = 1e-3});
    if (!compiled.plan) continue;  // keeps too many values at once
    LawCourses whole(model, *compiled.plan), point(model, *compiled.plan);
    const std::vector<int> laws{0};
    double from[2], to[2];
    for (int q : {0, 1}) {
      from[q] = random.uniform(-2, 2);
      to[q] = from[q] + std::pow(10, random.uniform(-4, 0.5)) * (random.chance(0.5) ? 1 : -1);
    }
    std::vector<Course> courses(2);
    for (int q : {0, 1})
      courses[at(q)] = {from[q], 0.5 * (from[q] + to[q]), to[q], std::min(from[q], to[q]), std::max(from[q], to[q])};
    whole.update(laws, {}, courses);
    const Course& law = whole.get(0);
    if (!std::isfinite(law.begin + law.middle + law.end)) continue;
    for (int k = 0; k <= 50; ++k) {
      const double s = k / 50.0;
      std::vector<Course> now(2);
      for (int q : {0, 1}) now[at(q)] = make_point(from[q] + s * (to[q] - from[q]));
      point.update(laws, {}, now);
      const double value = point.get(0).middle;
      if (!std::isfinite(value)) continue;
      ++judged;
      const double room = kRounding * (1 + std::abs(value));
      ASSERT_GE(value, law.low - room) << i << " at " << s;
      ASSERT_LE(value, law.high + room) << i << " at " << s;
    }
  }
  EXPECT_GT(judged, 50000);
}

}  // namespace
}  // namespace unlatch::test::law_courses_test
