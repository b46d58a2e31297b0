// Overrides, PATH=VALUE, of the command line or a scenario's `set`, put into a YAML tree before it is read, so that
// they are checked like the file itself. PATH goes down through mappings by `.key` and through lists by `[3]` or `.3`;
// an entry of a list that has a name is reached by `.name`, or `.name:subject` where several share the name (events).
// Missing keys are inserted. A plain number for a constant of the file keeps the (SI) unit of that constant.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/scenario/text/written_unit.h"
#include "hil/scenario/yaml/yaml_document.h"

namespace unlatch::hil {

// Parts of a path: "bodies", "core", "inertia", "0". Throws YamlError at `mark`.
std::vector<std::string> split_path(const std::string& path, const SourceMark& mark);

// Splits PATH=VALUE into path and value. Throws YamlError with the override's number as its place; so does
// apply_override().
std::pair<std::string, YamlNode> split_override(const std::string& text, int override_index);
void apply_override(const std::string& text, int override_index, YamlNode& root);

// Does the same for a path and a value in a file. Throws YamlError at `mark`.
void replace_value(const std::string& path, const SourceMark& mark, YamlNode value, YamlNode& root);

// Constants and channels that overrides or `set` have added, and constants to which they give another value, which no
// text of the tree names: misspelt, or of no use. Each with the place of its override.
std::vector<YamlError> list_unread_overrides(const YamlNode& root);
// Accepts those that some text names now: another override may replace that text later, as a sample's draw of a value
// that is computed from the constant.
void accept_read_overrides(YamlNode& root);
// Constants of the main file that no text of the tree names; included files may have some for others. Channels may be
// there for flight software alone.
std::vector<std::string> list_unread_constants(const YamlNode& root);

// Unit, other than that of SI, in which the text gives the constant at this path: "mm" of constants.gap: 2 mm. A plain
// number in its place would be one of SI. Nothing for other paths.
std::optional<WrittenUnit> find_constant_unit(const YamlNode& root, const std::string& path);
// True of a constant's path if no text of the tree reads that constant.
bool is_unread_constant(const YamlNode& root, const std::string& path);

// Node at a path; null if there is none. Throws YamlError at `mark` if the path itself is wrong.
const YamlNode* find_value(const std::string& path, const SourceMark& mark, const YamlNode& root);

}  // namespace unlatch::hil
