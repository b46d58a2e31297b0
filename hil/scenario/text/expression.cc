#include "hil/scenario/text/expression.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/text/utf8.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMaxBytes = 256;
constexpr int kMaxDepth = 24, kMaxExponent = 8;
constexpr double kStandardGravity = 9.80665;  // m/s2
constexpr Dimension kAngle{{0, 0, 0, 1}}, kAcceleration{{1, 0, -2, 0}};

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

const std::vector<std::string> kFunctions{"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "exp", "abs"};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string quote(std::string_view text) { return "'" + std::string(text) + "'"; }

Dimension add(Dimension a, const Dimension& b, int times) {
  for (std::size_t i = 0; i < a.exponents.size(); ++i) a.exponents[i] += times * b.exponents[i];
  return a;
}

void multiply(Quantity& q, const Quantity& by) {
  q.value *= by.value;
  q.dimension = add(q.dimension, by.dimension, 1);
}

void divide(Quantity& q, const Quantity& by) {
  if (by.value == 0) throw ExpressionError("a division by zero", "");
  q.value /= by.value;
  q.dimension = add(q.dimension, by.dimension, -1);
}

// A unit with a power, as written.
struct UnitPower {
  const Unit* unit;
  int exponent;
};

// Applies a unit. Divisors divide: 12 ms is 12 / 1000 s, rounded once.
void apply(Quantity& q, const UnitPower& power, int sign) {
  const Unit& unit = *power.unit;
  const int exponent = sign * power.exponent;
  for (int i = 0; i < std::abs(exponent); ++i)
    q.value = exponent > 0 ? q.value / unit.divisor * unit.factor : q.value * unit.divisor / unit.factor;
  q.dimension = add(q.dimension, unit.dimension, exponent);
}

// Finds `m`, and `m2` for m^2.
std::optional<UnitPower> find_unit_power(std::string_view name) {
  if (const Unit* unit = find_unit(name)) return UnitPower{unit, 1};
  if (name.size() < 2 || !is_digit(name.back())) return std::nullopt;
  const Unit* unit = find_unit(name.substr(0, name.size() - 1));
  if (!unit || name.back() < '2') return std::nullopt;
  return UnitPower{unit, name.back() - '0'};
}

double get_plain(const Quantity& q, const std::string& function) {
  if (q.dimension.is_plain()) return q.value;
  throw ExpressionError(function + " of " + describe_dimension(q.dimension), function + " takes a plain number");
}

double get_angle(const Quantity& q, const std::string& function) {
  if (kAngle.takes(q.dimension)) return q.value;
  throw ExpressionError(function + " of " + describe_dimension(q.dimension), function + " takes an angle");
}

Quantity calc_root(const Quantity& q) {
  Quantity root{std::sqrt(q.value), q.dimension};
  for (int& exponent : root.dimension.exponents) {
    if (exponent % 2 != 0) throw ExpressionError("sqrt of " + describe_dimension(q.dimension), "");
    exponent /= 2;
  }
  return root;
}

// Calls a function of one or two arguments. asin and acos use atan2, which is deterministic.
Quantity call(const std::string& function, const std::vector<Quantity>& arguments) {
  const std::size_t wanted = function == "atan2" ? 2 : 1;
  if (arguments.size() != wanted)
    throw ExpressionError(function + " of " + count(arguments.size(), "value"),
                          function + (wanted == 2 ? "(y, x)" : "(x)"));
  const Quantity& a = arguments[0];
  if (function == "sqrt") return calc_root(a);
  if (function == "abs") return {std::abs(a.value), a.dimension};
  if (function == "atan2") {
    if (a.dimension != arguments[1].dimension) throw ExpressionError("atan2 of different quantities", "atan2(y, x)");
    return {elementary::atan2(a.value, arguments[1].value), kAngle};
  }
  if (function == "exp") return {elementary::exp(get_plain(a, function)), {}};
  if (function == "sin") return {elementary::sin(get_angle(a, function)), {}};
  if (function == "cos") return {elementary::cos(get_angle(a, function)), {}};
  if (function == "tan") {
    double sine, cosine;
    elementary::sincos(get_angle(a, function), sine, cosine);
    return {sine / cosine, {}};
  }
  const double x = get_plain(a, function);
  if (function == "atan") return {elementary::atan2(x, 1), kAngle};
  const double other = std::sqrt((1 - x) * (1 + x));
  return {function == "asin" ? elementary::atan2(x, other) : elementary::atan2(other, x), kAngle};
}

class Parser {
 public:
  Parser(std::string_view written, const Constants& constants)
      : written_(written), own_(replace_symbols(written)), text_(own_), constants_(constants) {}

  Quantity read() {
    const Quantity q = read_sum();
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

  Quantity read_sum() {
    if (++depth_ > kMaxDepth) throw ExpressionError("more than 24 parentheses in each other", "name parts of it");
    Quantity sum = read_product();
    while (peek() == '+' || peek() == '-') {
      const double sign = text_[at_++] == '+' ? 1 : -1;
      const Quantity term = read_product();
      const bool same = sum.dimension.takes(term.dimension) || term.dimension.takes(sum.dimension);
      const auto is_zero = [](const Quantity& q) { return q.dimension.is_plain() && q.value == 0; };
      if (!same && !is_zero(sum) && !is_zero(term))  // zero is accepted in every unit
        throw ExpressionError(
            "a sum of " + describe_dimension(sum.dimension) + " and " + describe_dimension(term.dimension),
            "give both the same unit");
      if (same ? !sum.dimension.takes(term.dimension) : is_zero(sum)) sum.dimension = term.dimension;
      sum.value += sign * term.value;
    }
    --depth_;
    return sum;
  }

  Quantity read_product() {
    Quantity product{1, {}};
    if (const auto unit = take_unit())
      apply(product, *unit, 1);
    else
      product = read_sign();
    for (;;) {
      if (take('%')) {
        apply(product, {find_unit("%"), 1}, 1);
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
        apply(product, *unit, 1);
        continue;
      }
      if (const auto unit = take_unit())
        apply(product, *unit, divided ? -1 : 1);
      else if (divided)
        divide(product, read_sign());
      else
        multiply(product, read_sign());
    }
  }

  Quantity read_sign() {
    double sign = 1;
    while (peek() == '-' || peek() == '+')
      if (text_[at_++] == '-') sign = -sign;
    Quantity q = read_power();
    q.value *= sign;
    return q;
  }

  Quantity read_power() {
    Quantity base = read_primary();
    const int exponent = take_exponent();
    if (exponent == 1) return base;
    Quantity power{1, {}};
    for (int i = 0; i < std::abs(exponent); ++i) exponent > 0 ? multiply(power, base) : divide(power, base);
    return power;
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

  Quantity read_primary() {
    const char c = peek();
    if (take('(')) {
      const Quantity q = read_sum();
      if (!take(')')) throw ExpressionError("a missing ) in " + quote(written_), "");
      return q;
    }
    if (is_digit(c) || c == '.') return {read_literal(), {}};
    if (!is_letter(c))
      throw ExpressionError(c == '\0' ? quote(written_) + " ends too early" : quote(written_) + " is not a number", "");
    const std::string name = read_name();
    if (peek() == '(') return read_call(name);
    if (name == "pi") return {std::numbers::pi, {}};
    if (name == "g0") return {kStandardGravity, kAcceleration};
    if (const auto constant = constants_.find(name); constant != constants_.end()) return constant->second;
    refuse_name(name);
  }

  Quantity read_call(const std::string& name) {
    if (std::find(kFunctions.begin(), kFunctions.end(), name) == kFunctions.end())
      throw ExpressionError("unknown function " + quote(name), suggest(name, kFunctions));
    take('(');
    std::vector<Quantity> arguments{read_sum()};
    while (take(',')) arguments.push_back(read_sum());
    if (!take(')')) throw ExpressionError("a missing ) in " + quote(written_), "");
    return call(name, arguments);
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
    throw ExpressionError(quote(written_) + " is not a number: " + quote(name) + " is neither a unit nor a constant",
                          correct_name(name, constants));  // "": the reader lists the units that fit
  }

  const std::string_view written_;
  const std::string own_;  // with names for symbols
  const std::string_view text_;
  const Constants& constants_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

Quantity evaluate_expression(std::string_view text, const Constants& constants) {
  if (text.size() > kMaxBytes) throw ExpressionError("an expression of more than 256 bytes", "name parts of it");
  const Quantity q = Parser(text, constants).read();
  if (!std::isfinite(q.value))
    throw ExpressionError(quote(text) + (std::isnan(q.value) ? " is not defined" : " is beyond the range of a double"),
                          "");
  return q;
}

bool is_reserved_name(std::string_view name) {
  return name == "pi" || name == "g0" || find_unit_power(name) ||
         std::find(kFunctions.begin(), kFunctions.end(), name) != kFunctions.end();
}

}  // namespace unlatch::hil
