// A number with its noun, for messages: "1 sample", "2 samples".
#pragma once

#include <concepts>
#include <string>

namespace unlatch::hil {

// Regular nouns: "2 bodies", "2 touches".
template <std::integral Number>
std::string count(Number number, const std::string& noun) {
  const std::string text = std::to_string(number) + " ";
  if (number == 1) return text + noun;
  if (noun.ends_with('y')) return text + noun.substr(0, noun.size() - 1) + "ies";
  return text + noun + (noun.ends_with("ch") ? "es" : "s");
}

}  // namespace unlatch::hil
