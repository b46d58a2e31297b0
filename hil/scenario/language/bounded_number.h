// Numbers of the language whose bounds are in its tables (language.yaml, campaign.yaml, optimize.yaml): the bounds,
// and the message about a number outside of them, follow from the table.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hil/scenario/language/number_keys.h"
#include "hil/scenario/yaml/yaml_reader.h"

namespace unlatch::hil {

// The entry of a key of the tables: get_number_key("scenario.timing.spin"). A path that is not in a table does not
// compile.
consteval const NumberKey& get_number_key(std::string_view path) {
  for (const NumberKey& key : kNumberKeys)
    if (key.path == path) return key;
  throw "no number with bounds has this path in the tables of the language";
}

// Reads the key of `map`; absent, it is `fallback`, or required without one. Outside of its bounds it is a mistake with
// the range as correction, and the result is the fallback (0 without one).
double read_bounded(YamlMap& map, const NumberKey& key, std::optional<double> fallback, Mistakes& mistakes);
// The same of a number that is there already, at `mark`.
bool check_bounds(double value, const NumberKey& key, const SourceMark& mark, Mistakes& mistakes);
// "more than 0, at most 3600 s", "a whole number from 1 to 64".
std::string describe_bounds(const NumberKey& key);

}  // namespace unlatch::hil
