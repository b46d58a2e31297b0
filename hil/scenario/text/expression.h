// Arithmetic with units: `4380 kg`, `2*pi/3 rad`, `1/12 * 20 kg * (2 m)^2`, `sqrt(2) * radius`.
//
//   sum     = product { ("+" | "-") product }
//   product = sign { ("*" | "/") sign | unit }       from left to right: `2*pi/3 rad` is (2 pi / 3) rad
//   sign    = ["-" | "+"] sign | power
//   power   = primary ["^" integer]
//   primary = number | unit | constant | function "(" sum { "," sum } ")" | "(" sum ")"
//
// A unit may carry its exponent: m2 is m^2; % is a hundredth. In a sum both have one dimension; a plain 0 has any.
// Functions: sin cos tan asin acos atan atan2 sqrt exp abs; constants: pi, g0, and the scenario's own. The functions
// are the kernel's, so that a scenario has the same bits on every machine. The text is bounded: 256 bytes, 24
// parentheses deep.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "hil/scenario/text/quantity.h"

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

// Returns true for names that a scenario's own constants cannot have: units, functions, pi and g0.
bool is_reserved_name(std::string_view name);

}  // namespace unlatch::hil
