#include "hil/scenario/text/written_unit.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "hil/scenario/text/expression.h"

namespace unlatch::hil {
namespace {

// Units of data sheets that the language does not have elsewhere: h would be a common name of constants, and g is a
// gram.
struct SheetUnit {
  const char *name, *stands_for;
};
constexpr SheetUnit kSheetUnits[] = {{"µg", "(9.80665e-6 m/s2)"},
                                     {"μg", "(9.80665e-6 m/s2)"},
                                     {"ug", "(9.80665e-6 m/s2)"},
                                     {"mg", "(9.80665e-3 m/s2)"},
                                     {"Hz", "(1/s)"},
                                     {"h", "(3600 s)"},
                                     {"hr", "(3600 s)"},
                                     {"arcsec", "(4.8481368110953598e-06 rad)"},
                                     {"arcmin", "(2.9088820866572158e-04 rad)"},
                                     {"dps", "(1 deg/s)"},
                                     {"mdps", "(1e-3 deg/s)"},
                                     {"ppm", "(1e-6)"}};

// Letters, and the bytes of µ (micro sign) and μ (Greek letter) in UTF-8; not those of √.
bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '\xc2' || c == '\xb5' || c == '\xce' ||
         c == '\xbc';
}

// A number, a unit or a bracket before a unit: "15 µg" is a product, "15*µg" has its star already.
bool ends_with_factor(const std::string& text) {
  const std::size_t last = text.find_last_not_of(' ');
  return last != std::string::npos &&
         (std::isalnum(static_cast<unsigned char>(text[last])) != 0 || text[last] == '.' || text[last] == ')');
}

}  // namespace

std::string replace_sheet_units(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (!is_word(text[i])) {
      out += text[i++];
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && (is_word(text[end]) || (end > i && text[end] >= '0' && text[end] <= '9'))) ++end;
    const std::string word = text.substr(i, end - i);
    const auto* const unit = std::ranges::find(kSheetUnits, word, &SheetUnit::name);
    if (unit == std::end(kSheetUnits)) {
      out += word;
    } else {
      if (ends_with_factor(out)) out += '*';
      out += unit->stands_for;
    }
    i = end;
  }
  return out;
}

std::string square_root_unit(const std::string& text) {
  for (const std::string& root : {std::string("√"), std::string("sqrt(")}) {
    const std::size_t at = text.rfind(root);
    if (at == std::string::npos) continue;
    const std::size_t slash = text.find_last_not_of(' ', at == 0 ? 0 : at - 1);
    if (slash == std::string::npos || text[slash] != '/') continue;
    std::string under = text.substr(at + root.size());
    if (root.back() == '(') {
      const std::size_t close = under.rfind(')');
      if (close == std::string::npos) continue;
      under = under.substr(0, close);
    }
    return "(" + text.substr(0, slash) + ")^2/(" + under + ")";
  }
  return "";
}

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

std::optional<RootUnit> read_root_unit(const std::string& text) {
  const std::string squared = square_root_unit(replace_sheet_units(text));
  if (squared.empty()) return std::nullopt;
  RootUnit root;
  try {
    const Quantity square = evaluate_expression(squared, {});
    root.value = std::sqrt(square.value);
    Dimension base = square.dimension;
    int& time = base.exponents[Dimension::kTime];
    if (!(square.value >= 0) || time % 2 == 0) return std::nullopt;
    ++time;
    for (int& exponent : base.exponents) {
      if (exponent % 2 != 0) return std::nullopt;
      exponent /= 2;
    }
    const std::string unit = describe_unit(base);
    root.unit = unit + "/√s";
  } catch (const ExpressionError&) {
    return std::nullopt;
  }
  const std::size_t begin = text.find_first_not_of("+-.0123456789eE ");
  if (begin != std::string::npos && begin > 0) {
    const std::string name = text.substr(begin), one = square_root_unit(replace_sheet_units("1 " + name));
    if (!one.empty()) root.shown = WrittenUnit{name, std::sqrt(evaluate_expression(one, {}).value)};
  }
  return root;
}

}  // namespace unlatch::hil
