#include "hil/scenario/language/bounded_number.h"

#include <charconv>
#include <cmath>

namespace unlatch::hil {
namespace {

std::string to_plain_text(double value) {
  constexpr double kPlain = 1e10;  // whole numbers below it are written without an exponent
  char text[32];
  const bool plain = value == std::floor(value) && std::abs(value) < kPlain;
  const auto end = plain ? std::to_chars(text, text + sizeof text, static_cast<long long>(value))
                         : std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

std::string get_name(const NumberKey& key) { return std::string(key.path.substr(key.path.rfind('.') + 1)); }

}  // namespace

std::string describe_bounds(const NumberKey& key) {
  const std::string unit = key.unit.empty() ? "" : " " + std::string(key.unit);
  std::string text = key.whole ? "a whole number " : "";
  const bool least = std::isfinite(key.least), most = std::isfinite(key.most);
  if (least) text += (key.above ? "more than " : key.whole ? "from " : "at least ") + to_plain_text(key.least);
  if (least && most) text += key.whole && !key.above ? " to " : ", at most ";
  if (!least && most) text += "at most ";
  if (most) text += to_plain_text(key.most);
  return text + unit;
}

bool check_bounds(double value, const NumberKey& key, const SourceMark& mark, Mistakes& mistakes) {
  if (key.holds(value)) return true;
  mistakes.add(mark, "'" + get_name(key) + "' is out of its range", describe_bounds(key));
  return false;
}

double read_bounded(YamlMap& map, const NumberKey& key, std::optional<double> fallback, Mistakes& mistakes) {
  const std::string name = get_name(key);
  const YamlNode* const node = fallback ? map.find(name) : map.require(name);
  if (!node) return fallback.value_or(0.0);
  // A text that is no number is a mistake already, and reads as the least value that the bounds allow.
  const std::size_t before = mistakes.count();
  const double value = read_number(*node, std::string(key.unit), fallback.value_or(key.least), mistakes);
  if (mistakes.count() != before) return fallback.value_or(0.0);
  return check_bounds(value, key, node->mark, mistakes) ? value : fallback.value_or(0.0);
}

}  // namespace unlatch::hil
