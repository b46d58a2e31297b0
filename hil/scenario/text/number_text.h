// Numbers as text that is the same in every locale of the host's, unlike printf's and std::to_string's.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace unlatch::hil {

// The shortest decimal text that reads back as the same double; "inf" and "nan" for what is no number.
inline std::string write_number(double value) {
  std::array<char, 32> text{};
  const std::to_chars_result end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

// Six significant digits, for people.
inline std::string write_short(double value) {
  std::array<char, 32> text{};
  const std::to_chars_result end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), end.ptr};
}

}  // namespace unlatch::hil
