#include "hil/scenario/text/expression.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "hil/scenario/text/operands.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/text/utf8.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMaxBytes = 256, kMaxLawBytes = 4096;
constexpr int kMaxDepth = 24, kMaxExponent = 8;
constexpr double kStandardGravity = 9.80665;  // m/s2
constexpr Dimension kAcceleration{{1, 0, -2, 0}};

// Common wrong spellings, and their corrections.
constexpr std::pair<std::string_view, std::string_view> kSpellings[] = {
    {"sec", "s"},      {"second", "s"},    {"seconds", "s"},   {"msec", "ms"},     {"usec", "us"},
    {"minute", "min"}, {"minutes", "min"}, {"h", "60 min"},    {"hour", "60 min"}, {"hours", "60 min"},
    {"meter", "m"},    {"meters", "m"},    {"metre", "m"},     {"metres", "m"},    {"inch", "in"},
    {"inches", "in"},  {"foot", "ft"},     {"feet", "ft"},     {"lbs", "lb"},      {"lbm", "lb"},
    {"pound", "lb"},   {"pounds", "lb"},   {"kgs", "kg"},      {"ton", "t"},       {"tons", "t"},
    {"kgf", "g0 kg"},  {"newton", "N"},    {"newtons", "N"},   {"degree", "deg"},  {"degrees", "deg"},
    {"radian", "rad"}, {"radians", "rad"}, {"hertz", "Hz"},    {"cps", "Hz"},      {"joule", "J"},
    {"joules", "J"},   {"pascal", "Pa"},   {"bar", "100 kPa"}, {"psi", "lbf/in2"}, {"percent", "%"},
    {"w", "J/s"},      {"kw", "kJ/s"},     {"nm", "N m"},      {"knm", "kN m"},    {"gee", "g0"},
    {"dps", "deg/s"}};

// Symbols beyond ASCII, and how the language writes them.
constexpr std::pair<std::string_view, std::string_view> kSymbols[] = {
    {"°", " deg"}, {"µ", "u"},  {"μ", "u"},  // U+00B5, the micro sign, and U+03BC, the Greek letter
    {"·", "*"},    {"⋅", "*"},  {"×", "*"},  // U+00B7, U+22C5
    {"²", "^2"},   {"³", "^3"}, {"−", "-"}};

std::string replace_symbols(std::string_view text) {
  std::string replaced;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view point = get_code_point(text, i);
    const auto* const symbol =
        std::find_if(std::begin(kSymbols), std::end(kSymbols), [&](const auto& known) { return known.first == point; });
    replaced += symbol == std::end(kSymbols) ? point : symbol->second;
    i += point.size();
  }
  return replaced;
}

// Correction of a name that is neither a unit nor a constant: "" if no known name is near.
std::string correct_name(const std::string& name, const std::vector<std::string>& constants) {
  const std::string lower = to_lower(name);
  std::vector<std::string> known = list_unit_names();
  for (const std::string& unit : known)
    if (to_lower(unit) == lower) return "did you mean '" + unit + "'?";
  for (const auto& [spelling, right] : kSpellings)
    if (spelling == lower) return "did you mean '" + std::string(right) + "'?";
  known.insert(known.begin(), constants.begin(), constants.end());
  constexpr std::size_t kShort = 3;  // letters: one changed letter makes another such name
  const std::string* const nearest =
      name.size() < kShort ? nullptr : find_nearest(name, known, name.size() > kShort ? 2 : 1);
  return nearest == nullptr ? "" : "did you mean '" + *nearest + "'?";
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string quote(std::string_view text) { return "'" + std::string(text) + "'"; }

// Finds `m`, and `m2` for m^2.
std::optional<UnitPower> find_unit_power(std::string_view name) {
  if (const Unit* unit = find_unit(name)) return UnitPower{unit, 1};
  if (name.size() < 2 || !is_digit(name.back())) return std::nullopt;
  const Unit* unit = find_unit(name.substr(0, name.size() - 1));
  if (!unit || name.back() < '2') return std::nullopt;
  return UnitPower{unit, name.back() - '0'};
}

class Parser {
 public:
  // `names`: of a law; null for a number.
  Parser(std::string_view written, const Constants& constants, LawNames* names)
      : written_(written), own_(replace_symbols(written)), text_(own_), constants_(constants), names_(names) {}

  Operand read() {
    Operand q = read_sum();
    if (!at_end())
      throw ExpressionError("unexpected " + quote(get_code_point(text_, at_)) + " in " + quote(written_), "");
    return q;
  }

 private:
  bool at_end() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ == text_.size();
  }
  char peek() { return at_end() ? '\0' : text_[at_]; }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }

  Operand read_sum() {
    if (++depth_ > kMaxDepth) throw ExpressionError("more than 24 parentheses in each other", "name parts of it");
    Operand sum = read_product();
    while (peek() == '+' || peek() == '-') {
      const bool subtracts = text_[at_++] == '-';
      add(sum, read_product(), subtracts);
    }
    --depth_;
    return sum;
  }

  Operand read_product() {
    Operand product{{1, {}}, {}};
    if (const auto unit = take_unit())
      apply_unit(product, *unit, 1);
    else
      product = read_sign();
    for (;;) {
      if (take('%')) {
        apply_unit(product, {find_unit("%"), 1}, 1);
        continue;
      }
      const bool divided = peek() == '/';
      if (divided || peek() == '*')
        ++at_;
      else if (!is_letter(peek()))
        return product;
      else {
        const auto unit = take_unit();
        if (!unit) refuse_name(read_name());
        apply_unit(product, *unit, 1);
        continue;
      }
      if (const auto unit = take_unit())
        apply_unit(product, *unit, divided ? -1 : 1);
      else if (divided)
        divide(product, read_sign());
      else
        multiply(product, read_sign());
    }
  }

  Operand read_sign() {
    bool negative = false;
    while (peek() == '-' || peek() == '+')
      if (text_[at_++] == '-') negative = !negative;
    Operand operand = read_power();
    if (negative) negate(operand);
    return operand;
  }

  Operand read_power() {
    Operand base = read_primary();
    raise(base, take_exponent());
    return base;
  }

  int take_exponent() {
    if (!take('^')) return 1;
    const bool negative = take('-');
    int exponent = -1;
    if (!at_end() && is_digit(text_[at_])) exponent = text_[at_++] - '0';
    if (exponent < 0 || exponent > kMaxExponent || (!at_end() && (is_digit(text_[at_]) || text_[at_] == '.')))
      throw ExpressionError("an exponent that is not a whole number up to 8 in " + quote(written_),
                            "write x^2; roots are sqrt(x)");
    return negative ? -exponent : exponent;
  }

  Operand read_primary() {
    const char c = peek();
    if (take('(')) {
      Operand q = read_sum();
      if (!take(')')) throw ExpressionError("a missing ) in " + quote(written_), "");
      return q;
    }
    if (is_digit(c) || c == '.') return {{read_literal(), {}}, {}};
    if (!is_letter(c))
      throw ExpressionError(c == '\0' ? quote(written_) + " ends too early" : quote(written_) + " is not a number", "");
    const std::string name = read_name();
    if (peek() == '(') return read_call(name);
    if (name == "pi") return {{std::numbers::pi, {}}, {}};
    if (name == "g0") return {{kStandardGravity, kAcceleration}, {}};
    if (const auto constant = constants_.find(name); constant != constants_.end()) return {constant->second, {}};
    if (names_ != nullptr)
      if (std::optional<Operand> value = names_->find_value(name)) return *std::move(value);
    refuse_name(name);
  }

  Operand read_call(const std::string& name) {
    const std::optional<TableSignature> table = names_ == nullptr ? std::nullopt : names_->find_table(name);
    if (!table && !is_function(name))
      throw ExpressionError("unknown function " + quote(name), suggest(name, list_functions()));
    take('(');
    std::vector<Operand> arguments{read_sum()};
    while (take(',')) arguments.push_back(read_sum());
    if (!take(')')) throw ExpressionError("a missing ) in " + quote(written_), "");
    return table ? look_up(name, *table, arguments) : call_function(name, arguments);
  }

  double read_literal() {
    double value = 0;
    const char* const begin = text_.data() + at_;
    if (*begin == '0' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))
      throw ExpressionError(quote(written_) + " has a number with a leading zero, octal to YAML 1.1 tools",
                            "write it without the zero");
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error == std::errc::result_out_of_range)
      throw ExpressionError(quote(written_) + " is beyond the range of a double", "");
    if (error != std::errc()) throw ExpressionError(quote(written_) + " is not a number", "");
    at_ += static_cast<std::size_t>(end - begin);
    if (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.'))
      throw ExpressionError(quote(written_) + " is not a number", "");
    return value;
  }

  std::string read_name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }

  // Reads a unit and its power, if there is one; constants cannot have names of units, so the order of the two does not
  // matter.
  std::optional<UnitPower> take_unit() {
    if (!is_letter(peek())) return std::nullopt;
    const std::size_t begin = at_;
    auto unit = find_unit_power(read_name());
    if (!unit || peek() == '(') {
      at_ = begin;
      return std::nullopt;
    }
    unit->exponent *= take_exponent();
    return unit;
  }

  [[noreturn]] void refuse_name(const std::string& name) {
    if (constants_.count(name) > 0 || name == "pi" || name == "g0")
      throw ExpressionError(quote(name) + " directly behind a value", "write the product with *");
    std::vector<std::string> constants{"pi", "g0"};
    for (const auto& [constant, value] : constants_) constants.push_back(constant);
    if (names_ != nullptr) {
      const std::vector<std::string> known = names_->list_names();
      constants.insert(constants.end(), known.begin(), known.end());
      throw ExpressionError(quote(name) + " is neither a quantity, a channel, a table, a constant nor a unit",
                            correct_name(name, constants));
    }
    throw ExpressionError(quote(written_) + " is not a number: " + quote(name) + " is neither a unit nor a constant",
                          correct_name(name, constants));  // "": the reader lists the units that fit
  }

  const std::string_view written_;
  const std::string own_;  // with names for symbols
  const std::string_view text_;
  const Constants& constants_;
  LawNames* const names_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Quantity evaluate_expression(std::string_view text, const Constants& constants) {
  if (text.size() > kMaxBytes) throw ExpressionError("an expression of more than 256 bytes", "name parts of it");
  const Quantity q = Parser(text, constants, nullptr).read().quantity;
  if (!std::isfinite(q.value))
    throw ExpressionError(quote(text) + (std::isnan(q.value) ? " is not defined" : " is beyond the range of a double"),
                          "");
  return q;
}

Operand compile_expression(std::string_view text, const Constants& constants, LawNames& names) {
  if (text.size() > kMaxLawBytes) throw ExpressionError("an expression of more than 4096 bytes", "name parts of it");
  Operand operand = Parser(text, constants, &names).read();
  if (operand.steps.size() > kMostLawSteps)
    throw ExpressionError("an expression of more than " + std::to_string(kMostLawSteps) + " operations",
                          "name parts of it");
  if (operand.is_constant() && !std::isfinite(operand.quantity.value))
    throw ExpressionError(quote(text) + " is not a finite number", "");
  return operand;
}

bool is_reserved_name(std::string_view name) {
  return name == "pi" || name == "g0" || find_unit_power(name) ||
         std::ranges::find(list_reserved_functions(), name) != list_reserved_functions().end();
}

}  // namespace unlatch::hil
