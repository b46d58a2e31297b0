// Texts of notices and findings from patterns of printf.
#pragma once

#include <cstdio>
#include <string>

namespace unlatch::hil {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  const int length = std::snprintf(nullptr, 0, pattern, values...);
  std::string line(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  std::snprintf(line.data(), line.size() + 1, pattern, values...);
  return line;
}

}  // namespace unlatch::hil
