#include "hil/scenario/text/operands.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "hil/scenario/text/count.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

using Kind = LawStep::Kind;
constexpr Dimension kAngle{{0, 0, 0, 1}};

Dimension add(Dimension a, const Dimension& b, int times) {
  for (std::size_t i = 0; i < a.exponents.size(); ++i) a.exponents[i] += times * b.exponents[i];
  return a;
}

void append(const Operand& from, std::vector<LawStep>& to) {
  if (!from.is_constant()) {
    to.insert(to.end(), from.steps.begin(), from.steps.end());
    return;
  }
  if (!std::isfinite(from.quantity.value))
    throw ExpressionError("a part of the expression is not a finite number", "check its logarithms, roots and powers");
  to.push_back({Kind::kConstant, 0, from.quantity.value});
}

// `a` and `b` in postfix order, and what is done with them. Both must still have their values.
void join(Operand& a, const Operand& b, Kind kind) {
  std::vector<LawStep> steps;
  append(a, steps);
  append(b, steps);
  steps.push_back({kind, 0, 0});
  a.steps = std::move(steps);
}

double get_plain(const Operand& a, const std::string& function) {
  if (a.quantity.dimension.is_plain()) return a.quantity.value;
  throw ExpressionError(function + " of " + describe_dimension(a.quantity.dimension),
                        function + " takes a plain number");
}

double get_angle(const Operand& a, const std::string& function) {
  if (kAngle.takes(a.quantity.dimension)) return a.quantity.value;
  throw ExpressionError(function + " of " + describe_dimension(a.quantity.dimension), function + " takes an angle");
}

Dimension halve(Dimension dimension) {
  const Dimension whole = dimension;
  for (int& exponent : dimension.exponents) {
    if (exponent % 2 != 0) throw ExpressionError("sqrt of " + describe_dimension(whole), "");
    exponent /= 2;
  }
  return dimension;
}

bool is_zero(const Operand& a) { return a.is_constant() && a.quantity.dimension.is_plain() && a.quantity.value == 0; }

// The dimension that both have; zero is accepted in every unit. `what`: "a sum of".
Dimension unite(const Operand& a, const Operand& b, const std::string& what) {
  const Dimension &of_a = a.quantity.dimension, &of_b = b.quantity.dimension;
  const bool same = of_a.takes(of_b) || of_b.takes(of_a);
  if (!same && !is_zero(a) && !is_zero(b))
    throw ExpressionError(what + " " + describe_dimension(of_a) + " and " + describe_dimension(of_b),
                          "give both the same unit");
  return (same ? !of_a.takes(of_b) : is_zero(a)) ? of_b : of_a;
}

// asin and acos use atan2, which is deterministic.
double calc_asin(double x) { return elementary::atan2(x, std::sqrt((1 - x) * (1 + x))); }
double calc_acos(double x) { return elementary::atan2(std::sqrt((1 - x) * (1 + x)), x); }
double calc_tan(double x) {
  double sine, cosine;
  elementary::sincos(x, sine, cosine);
  return sine / cosine;
}

// A function: its name, the step of a run, and the calculation with its rule of dimensions. Of a step that a run
// computes the value does not count.
struct Function {
  const char* name;
  Kind kind;
  std::size_t arguments;
  const char* pattern;
  bool reserved;
  Quantity (*call)(const std::vector<Operand>& a);
};

const Function kFunctionTable[] = {
    {"sin", Kind::kSin, 1, "sin(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{elementary::sin(get_angle(a[0], "sin")), {}};
     }},
    {"cos", Kind::kCos, 1, "cos(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{elementary::cos(get_angle(a[0], "cos")), {}};
     }},
    {"tan", Kind::kTan, 1, "tan(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{calc_tan(get_angle(a[0], "tan")), {}};
     }},
    {"asin", Kind::kAsin, 1, "asin(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{calc_asin(get_plain(a[0], "asin")), kAngle};
     }},
    {"acos", Kind::kAcos, 1, "acos(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{calc_acos(get_plain(a[0], "acos")), kAngle};
     }},
    {"atan", Kind::kAtan, 1, "atan(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{elementary::atan2(get_plain(a[0], "atan"), 1), kAngle};
     }},
    {"atan2", Kind::kAtan2, 2, "atan2(y, x)", true,
     [](const std::vector<Operand>& a) {
       if (a[0].quantity.dimension != a[1].quantity.dimension)
         throw ExpressionError("atan2 of different quantities", "atan2(y, x)");
       return Quantity{elementary::atan2(a[0].quantity.value, a[1].quantity.value), kAngle};
     }},
    {"sqrt", Kind::kSqrt, 1, "sqrt(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{std::sqrt(a[0].quantity.value), halve(a[0].quantity.dimension)};
     }},
    {"exp", Kind::kExp, 1, "exp(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{elementary::exp(get_plain(a[0], "exp")), {}};
     }},
    {"abs", Kind::kAbs, 1, "abs(x)", true,
     [](const std::vector<Operand>& a) {
       return Quantity{std::abs(a[0].quantity.value), a[0].quantity.dimension};
     }},
    {"log", Kind::kLog, 1, "log(x)", false,
     [](const std::vector<Operand>& a) {
       return Quantity{elementary::log(get_plain(a[0], "log")), {}};
     }},
    {"min", Kind::kMin, 2, "min(a, b)", false,
     [](const std::vector<Operand>& a) {
       return Quantity{std::min(a[0].quantity.value, a[1].quantity.value), unite(a[0], a[1], "the smaller of")};
     }},
    {"max", Kind::kMax, 2, "max(a, b)", false,
     [](const std::vector<Operand>& a) {
       return Quantity{std::max(a[0].quantity.value, a[1].quantity.value), unite(a[0], a[1], "the larger of")};
     }},
    {"if_less", Kind::kIfLess, 4, "if_less(a, b, value if a < b, value otherwise)", false,
     [](const std::vector<Operand>& a) {
       (void)unite(a[0], a[1], "a comparison of");
       const Operand& chosen = a[0].quantity.value < a[1].quantity.value ? a[2] : a[3];
       return Quantity{chosen.quantity.value, unite(a[2], a[3], "a choice between")};
     }}};

std::vector<std::string> list_names(bool all) {
  std::vector<std::string> names;
  for (const Function& function : kFunctionTable)
    if (all || function.reserved) names.emplace_back(function.name);
  return names;
}

}  // namespace

void add(Operand& a, const Operand& b, bool subtracts) {
  const Dimension dimension = unite(a, b, "a sum of");
  const bool constant = a.is_constant() && b.is_constant();
  if (!constant) join(a, b, subtracts ? Kind::kSubtract : Kind::kAdd);
  a.quantity.value += (subtracts ? -1.0 : 1.0) * b.quantity.value;
  a.quantity.dimension = dimension;
}

void multiply(Operand& a, const Operand& by) {
  if (!a.is_constant() || !by.is_constant()) join(a, by, Kind::kMultiply);
  a.quantity.value *= by.quantity.value;
  a.quantity.dimension = add(a.quantity.dimension, by.quantity.dimension, 1);
}

void divide(Operand& a, const Operand& by) {
  if (by.is_constant() && by.quantity.value == 0) throw ExpressionError("a division by zero", "");
  if (!a.is_constant() || !by.is_constant()) join(a, by, Kind::kDivide);
  a.quantity.value /= by.quantity.value;
  a.quantity.dimension = add(a.quantity.dimension, by.quantity.dimension, -1);
}

void negate(Operand& a) {
  if (!a.is_constant()) a.steps.push_back({Kind::kNegate, 0, 0});
  a.quantity.value = -a.quantity.value;
}

void raise(Operand& a, int exponent) {
  if (exponent == 1) return;
  if (!a.is_constant()) {
    a.steps.push_back({Kind::kPower, exponent, 0});
    a.quantity.dimension = add({}, a.quantity.dimension, exponent);
    return;
  }
  Operand power{{1, {}}, {}};
  for (int i = 0; i < std::abs(exponent); ++i) exponent > 0 ? multiply(power, a) : divide(power, a);
  a = std::move(power);
}

void apply_unit(Operand& a, const UnitPower& power, int sign) {
  const Unit& unit = *power.unit;
  const int exponent = sign * power.exponent;
  const auto change = [&](Kind kind, double by) {
    if (!a.is_constant() && by != 1) join(a, {{by, {}}, {}}, kind);
  };
  for (int i = 0; i < std::abs(exponent); ++i) {
    change(exponent > 0 ? Kind::kDivide : Kind::kMultiply, unit.divisor);
    change(exponent > 0 ? Kind::kMultiply : Kind::kDivide, unit.factor);
    a.quantity.value =
        exponent > 0 ? a.quantity.value / unit.divisor * unit.factor : a.quantity.value * unit.divisor / unit.factor;
  }
  a.quantity.dimension = add(a.quantity.dimension, unit.dimension, exponent);
}

Operand look_up(const std::string& name, const TableSignature& table, const std::vector<Operand>& arguments) {
  if (arguments.size() != table.axes.size())
    throw ExpressionError("table '" + name + "' of " + count(arguments.size(), "value"),
                          "it takes " + count(table.axes.size(), "value") + ": one for each axis");
  Operand out{{1, table.value}, {}};
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const Dimension& given = arguments[i].quantity.dimension;
    if (table.axes[i] && !table.axes[i]->takes(given) && !is_zero(arguments[i]))
      throw ExpressionError("axis " + std::to_string(i + 1) + " of table '" + name + "' is " +
                                describe_dimension(*table.axes[i]) + ", not " + describe_dimension(given),
                            "give the value in its unit");
    append(arguments[i], out.steps);
  }
  out.steps.push_back({Kind::kTable, table.table, 0});
  return out;
}

const std::vector<std::string>& list_reserved_functions() {
  static const std::vector<std::string> kNames = list_names(false);
  return kNames;
}

const std::vector<std::string>& list_functions() {
  static const std::vector<std::string> kNames = list_names(true);
  return kNames;
}

bool is_function(const std::string& name) {
  return std::ranges::find(list_functions(), name) != list_functions().end();
}

Operand call_function(const std::string& name, const std::vector<Operand>& arguments) {
  const Function& function =
      *std::ranges::find_if(kFunctionTable, [&](const Function& known) { return name == known.name; });
  if (arguments.size() != function.arguments)
    throw ExpressionError(name + " of " + count(arguments.size(), "value"), function.pattern);
  Operand out{function.call(arguments), {}};
  if (std::ranges::all_of(arguments, [](const Operand& a) { return a.is_constant(); })) return out;
  for (const Operand& argument : arguments) append(argument, out.steps);
  out.steps.push_back({function.kind, 0, 0});
  return out;
}

}  // namespace unlatch::hil
