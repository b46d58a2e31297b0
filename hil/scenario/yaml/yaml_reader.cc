#include "hil/scenario/yaml/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "hil/scenario/text/count.h"
#include "hil/scenario/text/expression.h"
#include "hil/scenario/text/suggestion.h"

namespace unlatch::hil {
namespace {

std::string quote(const std::string& text) {
  constexpr std::size_t kShown = 40;
  return "'" + (text.size() > kShown ? text.substr(0, kShown) + "…" : text) + "'";
}

void expect(const YamlNode& node, const std::string& wanted, Mistakes& mistakes) {
  mistakes.add(node.mark, "a value of the wrong type: " + std::string(kind_name(node.kind)), "this must be " + wanted);
}

// Description of the expected number: in the SI unit `unit`, or in any if it is null. Both texts are for mistakes only:
// most numbers are correct, and no text is made for them.
std::string describe_wanted(const std::string* unit) {
  if (unit == nullptr) return "a number, such as 4380 kg";
  return "a number" + (unit->empty() ? "" : ", in " + *unit);
}

std::string describe_units(const std::string* unit) {
  if (unit == nullptr) return "write a number, such as 4380 kg";
  if (unit->empty()) return "write a plain number, such as 0.35";
  std::string text = "write a number in " + *unit;
  const std::vector<std::string> units = list_units(*unit);
  for (std::size_t i = 0; i < units.size(); ++i) text += (i == 0 ? ", or followed by " : ", ") + units[i];
  return text;
}

bool is_special(std::string text) {
  text = to_lower(std::move(text));
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.erase(0, 1);
  return text == ".nan" || text == ".inf" || text == "nan" || text == "inf" || text == "infinity";
}

// Reads an expression. `unit`: unit of the correct number, for mistakes, as in describe_wanted().
std::optional<Quantity> read_expression(const YamlNode& node, const std::string* unit, Mistakes& mistakes) {
  if (!node.is_scalar())
    expect(node, describe_wanted(unit), mistakes);
  else if (is_special(node.text))
    mistakes.add(node.mark, quote(node.text) + " is not finite", describe_units(unit));
  else
    try {
      return evaluate_expression(node.text, mistakes.constants());
    } catch (const ExpressionError& error) {
      mistakes.add(node.mark, error.what(), error.mend.empty() ? describe_units(unit) : error.mend);
    }
  return std::nullopt;
}

// Returns true for words that tools for YAML 1.1 read as true, false or null and write back as such. `y` and `n` are
// excluded: the common tools do not change them, and y is an axis.
bool is_yaml_1_1_word(const std::string& text) {
  static const std::vector<std::string> kWords{"true", "false", "yes", "no", "on", "off", "null"};
  return std::find(kWords.begin(), kWords.end(), to_lower(text)) != kWords.end();
}

// Correction of an unknown key. Old scenarios have `on`; a tool for YAML 1.1 has written it back as `true`.
std::string correct_key(const std::string& key, const std::vector<std::string>& known) {
  const bool renamed =
      (key == "on" || to_lower(key) == "true") && std::find(known.begin(), known.end(), "enabled") != known.end();
  return renamed ? "the key `on` is named `enabled` now: write `enabled: true` or `enabled: false`"
                 : suggest(key, known);
}

}  // namespace

std::optional<Quantity> read_quantity(const YamlNode& node, Mistakes& mistakes) {
  return read_expression(node, nullptr, mistakes);
}

double read_number(const YamlNode& node, const std::string& unit, double fallback, Mistakes& mistakes) {
  const auto quantity = read_expression(node, &unit, mistakes);
  if (!quantity) return fallback;
  const Dimension& given = quantity->dimension;
  if (given.is_plain() || dimension_of(unit).takes(given)) {
    mistakes.note_number(node, unit, quantity->value);
    return quantity->value;
  }
  mistakes.add(
      node.mark,
      quote(node.text) + " is " + describe_dimension(given) + ", not " + describe_dimension(dimension_of(unit)),
      describe_units(&unit));
  return fallback;
}

bool is_truth_value(const YamlNode& node) {
  return node.is_scalar() && (node.text == "true" || node.text == "false" || node.text == "on" || node.text == "off");
}

bool read_bool(const YamlNode& node, bool fallback, Mistakes& mistakes) {
  if (is_truth_value(node)) return node.text == "true" || node.text == "on";
  if (node.is_scalar())
    mistakes.add(node.mark, quote(node.text) + " is not a truth value", "write true or false");
  else
    expect(node, "true or false", mistakes);
  return fallback;
}

std::string read_text(const YamlNode& node, Mistakes& mistakes) {
  if (node.is_scalar()) return node.text;
  expect(node, "text", mistakes);
  return "";
}

bool is_name(const std::string& text) {
  constexpr std::size_t kMaxName = 40;
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto legal = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return !text.empty() && text.size() <= kMaxName && letter(text[0]) && std::all_of(text.begin(), text.end(), legal) &&
         !is_yaml_1_1_word(text);
}

std::string describe_name_rule(const std::string& text) {
  return is_yaml_1_1_word(text) ? "YAML 1.1 tools read this word as true, false or null; choose another name"
                                : "begin with a letter; letters, digits, _ and -; at most 40 characters";
}

std::string read_name(const YamlNode& node, Mistakes& mistakes) {
  std::string text = read_text(node, mistakes);
  if (node.is_scalar() && !is_name(text))
    mistakes.add(node.mark, quote(text) + " is not a name", describe_name_rule(text));
  return text;
}

std::vector<double> read_numbers(const YamlNode& node, std::size_t count, const std::string& unit, Mistakes& mistakes) {
  const std::string wanted = (count > 0 ? hil::count(count, "number") : "a list of numbers") +
                             (unit.empty() ? "" : ", in " + unit) + (count == 3 ? ": [x, y, z]" : "");
  if (!node.is_sequence()) {
    expect(node, wanted, mistakes);
    return std::vector<double>(count, 0.0);
  }
  if (count > 0 && node.items.size() != count)
    mistakes.add(node.mark, "a list of " + std::to_string(node.items.size()), "this must be " + wanted);
  std::vector<double> numbers;
  for (const YamlNode& item : node.items) numbers.push_back(read_number(item, unit, 0.0, mistakes));
  if (count > 0) numbers.resize(count, 0.0);
  return numbers;
}

Eigen::Vector3d read_vector(const YamlNode& node, const std::string& unit, const Eigen::Vector3d& fallback,
                            Mistakes& mistakes) {
  if (!node.sparse) {
    const std::vector<double> n = read_numbers(node, 3, unit, mistakes);
    return {n[0], n[1], n[2]};
  }
  Eigen::Vector3d vector = fallback;
  if (node.items.size() > 3) mistakes.add(node.items[3].mark, "a fourth component", "this has three: [0], [1], [2]");
  for (std::size_t i = 0; i < std::min<std::size_t>(3, node.items.size()); ++i)
    if (node.items[i].kind != YamlNode::Kind::kNull)
      vector[static_cast<Eigen::Index>(i)] = read_number(node.items[i], unit, 0.0, mistakes);
  return vector;
}

int read_choice(const YamlNode& node, const std::string& kind, const std::vector<std::string>& choices,
                Mistakes& mistakes) {
  if (!node.is_scalar()) {
    expect(node, "the name of a " + kind, mistakes);
    return -1;
  }
  const auto at = std::find(choices.begin(), choices.end(), node.text);
  if (at != choices.end()) return static_cast<int>(at - choices.begin());
  mistakes.add(node.mark, "unknown " + kind + " " + quote(node.text), suggest(node.text, choices));
  return -1;
}

// --- YamlMap --------------------------------------------------------------------------------------------------------

namespace {

std::vector<std::string> list_distinct(const std::vector<std::string>& all) {
  std::vector<std::string> list;
  for (const std::string& one : all)
    if (std::find(list.begin(), list.end(), one) == list.end()) list.push_back(one);
  return list;
}

}  // namespace

YamlMap::YamlMap(const YamlNode& node, std::string what, Mistakes& mistakes)
    : node_(node), what_(std::move(what)), mistakes_(mistakes) {
  if (!node.is_mapping()) expect(node, "a mapping (key: value) that describes " + what_, mistakes);
}

const YamlNode* YamlMap::find(const std::string& key) {
  known_.push_back(key);  // some several times: finish() sorts them out if it needs them
  return node_.find(key);
}

const YamlNode* YamlMap::require(const std::string& key) {
  const YamlNode* value = find(key);
  if (!value && node_.is_mapping()) mistakes_.add(node_.mark, what_ + " has no " + key, "add `" + key + ": …`");
  return value;
}

void YamlMap::read_header(const std::string& key) {
  constexpr int kVersion = 1;
  const std::string right = "`" + key + ": " + std::to_string(kVersion) + "`";
  const YamlNode* const version = find(key);
  if (version == nullptr)
    mistakes_.add(node_.mark, "missing header", "add " + right);
  else if (read_number(*version, "", kVersion, mistakes_) != kVersion)
    mistakes_.add(version->mark, "another version of the language", "this program reads " + right);
}

double YamlMap::number(const std::string& key, const std::string& unit, std::optional<double> fallback) {
  const YamlNode* value = fallback ? find(key) : require(key);
  return value ? read_number(*value, unit, fallback.value_or(0.0), mistakes_) : fallback.value_or(0.0);
}

bool YamlMap::boolean(const std::string& key, bool fallback) {
  const YamlNode* value = find(key);
  return value ? read_bool(*value, fallback, mistakes_) : fallback;
}

Eigen::Vector3d YamlMap::vector(const std::string& key, const std::string& unit,
                                const std::optional<Eigen::Vector3d>& fallback) {
  const YamlNode* value = fallback ? find(key) : require(key);
  const Eigen::Vector3d otherwise = fallback.value_or(Eigen::Vector3d::Zero());
  return value ? read_vector(*value, unit, otherwise, mistakes_) : otherwise;
}

int YamlMap::choice(const std::string& key, const std::string& kind, const std::vector<std::string>& choices) {
  const YamlNode* value = require(key);
  return value ? read_choice(*value, kind, choices, mistakes_) : -1;
}

int YamlMap::choice(const std::string& key, const std::string& kind, const std::vector<std::string>& choices,
                    int fallback) {
  const YamlNode* value = find(key);
  return value ? read_choice(*value, kind, choices, mistakes_) : fallback;
}

std::string YamlMap::only_one_of(const std::vector<std::string>& keys, const std::string& need) {
  std::string found;
  for (const std::string& key : keys) {
    if (!find(key)) continue;
    if (!found.empty()) {
      mistakes_.add(node_.mark, what_ + " has both " + found + " and " + key, "write one of them");
      return "";
    }
    found = key;
  }
  if (found.empty() && node_.is_mapping()) {
    std::string list;
    for (const std::string& key : keys) list += (list.empty() ? "" : ", ") + key;
    mistakes_.add(node_.mark, what_ + " needs " + need, "write one of: " + list);
  }
  return found;
}

void YamlMap::finish() {
  for (std::size_t i = 0; i < node_.keys.size(); ++i) {
    const YamlKey& key = node_.keys[i];
    const auto same = [&](const YamlKey& other) { return other.text == key.text; };
    const auto first = std::find_if(node_.keys.begin(), node_.keys.end(), same);
    if (first < node_.keys.begin() + static_cast<std::ptrdiff_t>(i))
      mistakes_.add(key.mark, "duplicate key " + quote(key.text),
                    "it was first given " + mistakes_.describe(first->mark, key.mark) + ": keep one");
    else if (std::find(known_.begin(), known_.end(), key.text) == known_.end())
      mistakes_.add(key.mark, "unknown key " + quote(key.text) + " in " + what_,
                    correct_key(key.text, list_distinct(known_)));
  }
}

}  // namespace unlatch::hil
