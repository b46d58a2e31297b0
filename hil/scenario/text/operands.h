// Operand: a number of an expression under way, a constant or steps that a run computes; and what can be done with it:
// sums, products, units, functions, each with its rule of dimensions.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/text/expression.h"

namespace unlatch::hil {

// A unit with a power, as written.
struct UnitPower {
  const Unit* unit;
  int exponent;
};

// `a` becomes the result. Throw ExpressionError.
void add(Operand& a, const Operand& b, bool subtracts);
void multiply(Operand& a, const Operand& by);
void divide(Operand& a, const Operand& by);
void negate(Operand& a);
void raise(Operand& a, int exponent);
// Applies a unit. Divisors divide: 12 ms is 12 / 1000 s, rounded once.
void apply_unit(Operand& a, const UnitPower& power, int sign);
// A table at one argument per axis.
Operand look_up(const std::string& name, const TableSignature& table, const std::vector<Operand>& arguments);

// Names of functions that constants cannot have, and further ones, which are functions only before a parenthesis.
const std::vector<std::string>& list_reserved_functions();
bool is_function(const std::string& name);
const std::vector<std::string>& list_functions();
// Calls a function.
Operand call_function(const std::string& name, const std::vector<Operand>& arguments);

}  // namespace unlatch::hil
