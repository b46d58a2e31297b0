#include "hil/scenario/language/record.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace unlatch::hil {

const std::vector<std::string> kBasisNames{"measured", "datasheet", "assumed", "derived"};

namespace {

bool contains(const std::vector<std::string>& list, const std::string& text) {
  return std::ranges::find(list, text) != list.end();
}

bool has_only_scalars(const YamlNode& node) {
  if (node.is_scalar()) return true;
  return node.is_sequence() && std::ranges::all_of(node.items, has_only_scalars);
}

std::string write(const YamlNode& node) {
  if (node.is_scalar()) return node.text;
  std::string text = "[";
  for (const YamlNode& item : node.items) text += (&item == node.items.data() ? "" : ", ") + write(item);
  return text + "]";
}

// Words of a text: letters, digits and _, beginning with a letter.
std::vector<std::string> list_words(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::vector<std::string> words;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (end < text.size() && (is_letter(text[end]) || is_digit(text[end]))) ++end;
    if (end > i && is_letter(text[i])) words.push_back(text.substr(i, end - i));
    i = std::max(end, i + 1);
  }
  return words;
}

class Collector {
 public:
  Collector(const YamlNode& root, const std::vector<Basis>& basis, const Mistakes& mistakes)
      : root_(root), mistakes_(mistakes) {
    for (const NumberRead& number : mistakes.numbers()) numbers_.emplace(number.node, &number);
    for (std::size_t i = 0; i < basis.size(); ++i)
      for (const PathPattern& pattern : basis[i].of)
        for (const YamlNode* const node : find_matches(pattern, root)) covers_[node] = static_cast<int>(i);
  }

  std::vector<DataValue> collect() {
    for (std::size_t i = 0; i < root_.keys.size(); ++i) {
      section_ = root_.keys[i].text;
      if (contains(list_data_sections(), section_)) walk(root_.items[i], section_, section_, -1);
    }
    return std::move(found_);
  }

 private:
  // `key`: the last key of the path.
  void walk(const YamlNode& node, const std::string& path, const std::string& key, int basis) {
    if (const auto at = covers_.find(&node); at != covers_.end()) basis = std::max(basis, at->second);
    if (has_only_scalars(node)) {
      if (is_data(node, path, key)) add(node, path, key, cover_below(node, basis));
      return;
    }
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      if (node.is_mapping()) {
        walk(node.items[i], path + "." + node.keys[i].text, node.keys[i].text, basis);
      } else {
        const std::string name = get_entry_name(node, i);
        walk(node.items[i], path + (name.empty() ? "[" + std::to_string(i) + "]" : "." + name), key, basis);
      }
    }
  }

  // An entry may name a number of a list alone; the list has its basis then.
  int cover_below(const YamlNode& node, int basis) const {
    for (const YamlNode& item : node.items) {
      if (const auto at = covers_.find(&item); at != covers_.end()) basis = std::max(basis, at->second);
      basis = cover_below(item, basis);
    }
    return basis;
  }

  bool has_number(const YamlNode& node) const {
    return numbers_.contains(&node) ||
           std::ranges::any_of(node.items, [&](const YamlNode& n) { return has_number(n); });
  }

  // Numbers of constants, tables and errors of sensors are read in ways of their own.
  bool is_data(const YamlNode& node, const std::string& path, const std::string& key) const {
    if (has_number(node) || key == "expression" || key == "file") return true;
    if (section_ == "constants") return true;
    if (section_ == "tables") return key == "values" || key == "at";
    return section_ == "sensors" && path.find(".errors.") != std::string::npos;
  }

  bool is_input(const std::string& key) const {
    static const std::vector<std::string> kSections{"gravity", "environment", "start", "channels", "events"};
    static const std::vector<std::string> kStart{"position", "attitude", "velocity", "rate"};
    return contains(kSections, section_) || (section_ == "bodies" && contains(kStart, key));
  }

  void add_numbers(const YamlNode& node, DataValue& to) const {
    if (const auto at = numbers_.find(&node); at != numbers_.end()) {
      to.unit = at->second->unit;
      to.numbers.push_back(at->second->value);
    }
    for (const YamlNode& item : node.items) add_numbers(item, to);
  }

  void add(const YamlNode& node, const std::string& path, const std::string& key, int basis) {
    DataValue value;
    value.path = path;
    value.text = write(node);
    value.mark = node.mark;
    value.role = is_input(key) ? DataValue::Role::kInput : DataValue::Role::kModel;
    value.is_expression = key == "expression";
    value.basis = basis;
    add_numbers(node, value);
    if (key != "file")
      for (const std::string& word : list_words(value.text))
        if (mistakes_.constants().contains(word) && !contains(value.constants, word)) value.constants.push_back(word);
    found_.push_back(std::move(value));
  }

  const YamlNode& root_;
  const Mistakes& mistakes_;
  std::unordered_map<const YamlNode*, const NumberRead*> numbers_;
  std::unordered_map<const YamlNode*, int> covers_;
  std::string section_;
  std::vector<DataValue> found_;
};

}  // namespace

const std::vector<std::string>& list_data_sections() {
  static const std::vector<std::string> names{"constants", "gravity",    "environment", "bodies", "start",
                                              "ground",    "joints",     "elements",    "stops",  "channels",
                                              "tables",    "quantities", "sensors",     "events", "contacts"};
  return names;
}

std::vector<DataValue> list_data(const YamlNode& root, const std::vector<Basis>& basis, const Mistakes& mistakes) {
  return Collector(root, basis, mistakes).collect();
}

std::vector<double> calc_uncertainties(const DataValue& value, const std::vector<Basis>& basis) {
  if (value.basis < 0) return {};
  const std::optional<Quantity>& stated = basis[static_cast<std::size_t>(value.basis)].uncertainty;
  if (!stated) return {};
  std::vector<double> sizes;
  for (const double number : value.numbers)
    sizes.push_back(stated->dimension.is_plain() ? stated->value * std::abs(number) : stated->value);
  return sizes;
}

}  // namespace unlatch::hil
