// Patterns of paths: as overrides write them, with * for any characters within a part. `bodies.booster*.mass`.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

struct PathPattern {
  std::string text;
  std::vector<std::string> parts;
  [[nodiscard]] bool has_wildcard() const { return text.find('*') != std::string::npos; }
};

// Throws YamlError at `mark`.
PathPattern parse_pattern(const std::string& text, const SourceMark& mark);

// Nodes at the paths that match, in the order of the tree.
std::vector<const YamlNode*> find_matches(const PathPattern& pattern, const YamlNode& root);

// The correction of a pattern that matches nothing: the names that its first wrong part may have.
std::string correct_pattern(const PathPattern& pattern, const YamlNode& root);

// Name of an entry of a list by which a path reaches it alone: `id`, `name` or `name:subject`; "" if it has none.
std::string get_entry_name(const YamlNode& list, std::size_t index);

}  // namespace unlatch::hil
