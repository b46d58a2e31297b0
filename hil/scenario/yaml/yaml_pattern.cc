#include "hil/scenario/yaml/yaml_pattern.h"

#include <algorithm>

#include "hil/scenario/text/suggestion.h"
#include "hil/scenario/text/wildcard.h"
#include "hil/scenario/yaml/yaml_override.h"

namespace unlatch::hil {
namespace {

// Names by which a path may reach an entry of a list, beside its number.
std::vector<std::string> list_names(const YamlNode& entry) {
  const YamlNode* const id = entry.find("id");
  const YamlNode* const name = id != nullptr ? id : entry.find("name");
  if (name == nullptr || !name->is_scalar()) return {};
  std::vector<std::string> names{name->text};
  if (const YamlNode* const subject = entry.find("subject"); subject != nullptr && subject->is_scalar())
    names.push_back(name->text + ":" + subject->text);
  return names;
}

std::vector<std::string> list_names_of(const YamlNode& node, std::size_t index) {
  if (node.is_mapping()) return {node.keys[index].text};
  std::vector<std::string> names = list_names(node.items[index]);
  names.push_back(std::to_string(index));
  return names;
}

bool matches_entry(const std::string& part, const YamlNode& node, std::size_t index) {
  return std::ranges::any_of(list_names_of(node, index),
                             [&](const std::string& name) { return matches_text(part, name); });
}

void find_from(const PathPattern& pattern, std::size_t at, const YamlNode& node, std::vector<const YamlNode*>& found) {
  if (at == pattern.parts.size()) {
    found.push_back(&node);
    return;
  }
  for (std::size_t i = 0; i < node.items.size(); ++i)
    if (matches_entry(pattern.parts[at], node, i)) find_from(pattern, at + 1, node.items[i], found);
}

}  // namespace

PathPattern parse_pattern(const std::string& text, const SourceMark& mark) { return {text, split_path(text, mark)}; }

std::vector<const YamlNode*> find_matches(const PathPattern& pattern, const YamlNode& root) {
  std::vector<const YamlNode*> found;
  find_from(pattern, 0, root, found);
  return found;
}

std::string correct_pattern(const PathPattern& pattern, const YamlNode& root) {
  PathPattern tried{pattern.text, {}};
  for (const std::string& part : pattern.parts) {
    std::vector<std::string> known;
    for (const YamlNode* const node : find_matches(tried, root))
      for (std::size_t i = 0; i < node->items.size(); ++i)
        for (const std::string& name : list_names_of(*node, i))
          if (std::ranges::find(known, name) == known.end()) known.push_back(name);
    if (known.empty()) return "nothing is inside of '" + tried.parts.back() + "': shorten the path";
    tried.parts.push_back(part);
    if (find_matches(tried, root).empty()) return suggest(part, known);
  }
  return "";
}

std::string get_entry_name(const YamlNode& list, std::size_t index) {
  const std::vector<std::string> names = list_names(list.items[index]);
  for (const std::string& name : names) {
    const auto shared = std::ranges::count_if(list.items, [&](const YamlNode& other) {
      const std::vector<std::string> of_other = list_names(other);
      return std::ranges::find(of_other, name) != of_other.end();
    });
    if (shared == 1) return name;
  }
  return "";
}

}  // namespace unlatch::hil
