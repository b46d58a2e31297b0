// Single steps of laws: what they take, and their values; for the step (laws.cc), and for bounds of laws over a short
// time (law_courses.cc).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iterator>

#include "kernel/math/index.h"
#include "kernel/math/spatial.h"
#include "kernel/plan/plan_laws.h"
#include "unlatch/elementary.h"
#include "unlatch/step_data.h"

namespace unlatch {

// What the `subject` of a kind of step is.
enum class LawSubject { kUnknown, kNothing, kExponent, kQuantity, kChannel, kTable };

// What a kind of step takes from the stack. All put one value there.
struct LawOperands {
  std::int32_t takes;  // values; of a table none here: one for each of its axes
  bool decides;        // it has a branch, or a corner: what decides it is kept in Evaluation::law_places
  LawSubject of;       // its subject
};
// By LawStep::Kind.
inline constexpr LawOperands kLawOperands[] = {
    {0, false, LawSubject::kNothing},   // constant
    {0, false, LawSubject::kQuantity},  // quantity
    {0, false, LawSubject::kChannel},   // command
    {0, false, LawSubject::kTable},     // table
    {2, false, LawSubject::kNothing},   // add
    {2, false, LawSubject::kNothing},   // subtract
    {2, false, LawSubject::kNothing},   // multiply
    {2, false, LawSubject::kNothing},   // divide
    {1, false, LawSubject::kExponent},  // power
    {1, false, LawSubject::kNothing},   // negate
    {1, false, LawSubject::kNothing},   // sqrt
    {1, true, LawSubject::kNothing},    // abs
    {1, false, LawSubject::kNothing},   // sin
    {1, false, LawSubject::kNothing},   // cos
    {1, false, LawSubject::kNothing},   // tan
    {1, false, LawSubject::kNothing},   // asin
    {1, false, LawSubject::kNothing},   // acos
    {1, false, LawSubject::kNothing},   // atan
    {2, false, LawSubject::kNothing},   // atan2
    {1, false, LawSubject::kNothing},   // exp
    {1, false, LawSubject::kNothing},   // log
    {2, true, LawSubject::kNothing},    // min
    {2, true, LawSubject::kNothing},    // max
    {4, true, LawSubject::kNothing},    // if_less
};
static_assert(std::size(kLawOperands) == static_cast<std::size_t>(LawStep::Kind::kIfLess) + 1);
static_assert(std::ranges::none_of(kLawOperands, [](const LawOperands& own) { return own.of == LawSubject::kUnknown; }),
              "each row says what its subject is");
constexpr const LawOperands& get_operands(LawStep::Kind kind) { return kLawOperands[static_cast<std::size_t>(kind)]; }

// value · scale · command + offset + command
template <class Scaled>
double rescale(const Scaled& own, const Inputs& inputs, double value) {
  value *= own.scale;
  if (own.scale_channel != kNone) value *= inputs.commands[at(own.scale_channel)];
  value += own.offset;
  if (own.offset_channel != kNone) value += inputs.commands[at(own.offset_channel)];
  return value;
}

inline double calc_power(double a, std::int32_t exponent) {
  double power = 1;
  for (std::int32_t i = 0; i < std::abs(exponent); ++i) power *= a;
  return exponent < 0 ? 1 / power : power;
}

// asin and acos by atan2, which has the same bits everywhere; beyond ±1 they are NaN.
inline double calc_asin(double x) { return elementary::atan2(x, std::sqrt((1 - x) * (1 + x))); }
inline double calc_acos(double x) { return elementary::atan2(std::sqrt((1 - x) * (1 + x)), x); }

inline double calc_tan(double x) {
  double sine, cosine;
  elementary::sincos(x, sine, cosine);
  return sine / cosine;
}

// A step of one argument.
UNLATCH_INLINE double apply(const PlanLawStep& step, double a) {
  using Kind = LawStep::Kind;
  switch (step.kind) {
    case Kind::kPower:
      return calc_power(a, step.subject);
    case Kind::kNegate:
      return -a;
    case Kind::kSqrt:
      return std::sqrt(a);
    case Kind::kAbs:
      return std::abs(a);
    case Kind::kSin:
      return elementary::sin(a);
    case Kind::kCos:
      return elementary::cos(a);
    case Kind::kTan:
      return calc_tan(a);
    case Kind::kAsin:
      return calc_asin(a);
    case Kind::kAcos:
      return calc_acos(a);
    case Kind::kAtan:
      return elementary::atan2(a, 1);
    case Kind::kExp:
      return elementary::exp(a);
    default:
      return elementary::log(a);
  }
}

// A step of two arguments. The minimum and the maximum of NaN and a number are NaN.
UNLATCH_INLINE double apply(const PlanLawStep& step, double a, double b) {
  using Kind = LawStep::Kind;
  switch (step.kind) {
    case Kind::kAdd:
      return a + b;
    case Kind::kSubtract:
      return a - b;
    case Kind::kMultiply:
      return a * b;
    case Kind::kDivide:
      return a / b;
    case Kind::kAtan2:
      return elementary::atan2(a, b);
    case Kind::kMin:
      return a < b || a != a ? a : b;
    default:
      return a > b || a != a ? a : b;
  }
}

}  // namespace unlatch
