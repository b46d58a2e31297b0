// Arithmetic with units: `4380 kg`, `2*pi/3 rad`, `1/12 * 20 kg * (2 m)^2`, `sqrt(2) * radius`.
//
//   sum     = product { ("+" | "-") product }
//   product = sign { ("*" | "/") sign | unit }       from left to right: `2*pi/3 rad` is (2 pi / 3) rad
//   sign    = ["-" | "+"] sign | power
//   power   = primary ["^" integer]
//   primary = number | unit | constant | function "(" sum { "," sum } ")" | "(" sum ")"
//
// A unit may carry its exponent: m2 is m^2; % is a hundredth. In a sum both have one dimension; a plain 0 has any.
// Functions: sin cos tan asin acos atan atan2 sqrt exp log abs min max if_less; constants: pi, g0, and the scenario's
// own. The functions are the kernel's, so that a scenario has the same bits on every machine. The text is bounded: 256
// bytes, 24 parentheses deep.
//
// The expression of a law (unlatch/model/law.h) may also name what a run knows: quantities, channels, tables. It is
// compiled to steps, and has 4096 bytes and kMostLawSteps operations at most.
#pragma once

#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hil/scenario/text/quantity.h"
#include "unlatch/model/law.h"

namespace unlatch::hil {

using Constants = std::map<std::string, Quantity, std::less<>>;

class ExpressionError : public std::runtime_error {
 public:
  ExpressionError(const std::string& what_in, std::string mend_in)
      : std::runtime_error(what_in), mend(std::move(mend_in)) {}
  std::string mend;  // correction; may be empty
};

// Evaluates an expression. Throws ExpressionError. The value is finite.
Quantity evaluate_expression(std::string_view text, const Constants& constants);

// A number of an expression: a constant, or steps that a run computes; then only the dimension of `quantity` counts.
struct Operand {
  Quantity quantity;
  std::vector<LawStep> steps;
  bool is_constant() const { return steps.empty(); }
};

// A table as an expression calls it: its number, the dimensions of its axes (nothing: any) and of its values.
struct TableSignature {
  int table = 0;
  std::vector<std::optional<Dimension>> axes;
  Dimension value;
};

// Names that the expression of a law may use beside units, constants and functions.
class LawNames {
 public:
  virtual ~LawNames() = default;
  // A name that stands alone; nothing if it is none. May throw ExpressionError.
  virtual std::optional<Operand> find_value(const std::string& name) = 0;
  // A name with arguments.
  virtual std::optional<TableSignature> find_table(const std::string& name) = 0;
  // All, for suggestions.
  virtual std::vector<std::string> list_names() = 0;
};

// Compiles the expression of a law. Throws ExpressionError.
Operand compile_expression(std::string_view text, const Constants& constants, LawNames& names);

// Returns true for names that a scenario's own constants cannot have: units, functions, pi and g0.
bool is_reserved_name(std::string_view name);

}  // namespace unlatch::hil
