// Texts of notices and findings from patterns of printf, at most 319 bytes.
#pragma once

#include <cstdio>
#include <string>

namespace unlatch::hil {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char line[320];
  std::snprintf(line, sizeof line, pattern, values...);
  return line;
}

}  // namespace unlatch::hil
