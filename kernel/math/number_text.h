// Numbers in messages for people: six significant digits, the same in every locale of the host program.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace unlatch {

inline std::string show(double value) {
  std::array<char, 32> text{};
  const std::to_chars_result end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
  return {text.data(), end.ptr};
}

}  // namespace unlatch
