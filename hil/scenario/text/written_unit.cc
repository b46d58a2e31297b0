#include "hil/scenario/text/written_unit.h"

#include <charconv>

#include "hil/scenario/text/expression.h"

namespace unlatch::hil {

std::optional<WrittenUnit> find_written_unit(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" +");
  if (begin == std::string::npos) return std::nullopt;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  const std::size_t from = text.find_first_not_of(' ', static_cast<std::size_t>(end - text.data()));
  if (from == std::string::npos) return std::nullopt;
  // A unit alone behind a number is arithmetic too, but for signs, sums and products with numbers in front.
  const std::string unit = text.substr(from, text.find_last_not_of(' ') + 1 - from);
  if (std::string("+-*/^(").find(unit[0]) != std::string::npos) return std::nullopt;
  try {
    const Quantity one = evaluate_expression("1 " + unit, {}), ten = evaluate_expression("10 " + unit, {});
    if (one.dimension.is_plain() || !(ten.value == 10 * one.value)) return std::nullopt;  // a sum, or a plain number
    return WrittenUnit{unit, one.value};
  } catch (const ExpressionError&) {
    return std::nullopt;
  }
}

}  // namespace unlatch::hil
