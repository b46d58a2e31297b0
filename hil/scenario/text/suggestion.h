// Suggestions for a name that is not known.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace unlatch::hil {

// Letters A to Z in lower case, independent of the locale.
std::string to_lower(std::string text);

// Nearest of `known` to `wrong`, by Levenshtein's distance; nullptr if that is more than `limit`.
const std::string* find_nearest(const std::string& wrong, const std::vector<std::string>& known, std::size_t limit);

// Suggestion from the known names: "did you mean 'mass'? known: …".
std::string suggest(const std::string& wrong, const std::vector<std::string>& known);

}  // namespace unlatch::hil
