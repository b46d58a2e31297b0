// UTF-8 text by code point: what is quoted or cut ends where a code point does.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

namespace unlatch::hil {

// Length of the UTF-8 sequence that begins at text[i], 0 if it is not valid (overlong forms, surrogates and values
// beyond U+10FFFF included).
inline std::size_t get_utf8_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(text[k]); };
  const std::uint8_t lead = byte(i);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : (lead >= 0xe0 ? 3 : 2);
  if (lead < 0xc2 || lead > 0xf4 || i + length > text.size()) return 0;
  std::uint32_t code = lead & (0xffu >> (length + 1));
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(i + k) & 0x3fu);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  return overlong || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff ? 0 : length;
}

// The code point at text[i], or its byte if that is not valid UTF-8.
inline std::string_view get_code_point(std::string_view text, std::size_t i) {
  return text.substr(i, std::max<std::size_t>(1, get_utf8_length(text, i)));
}

// The longest beginning of at most `most` bytes that does not cut a code point.
inline std::string_view cut_text(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && (static_cast<std::uint8_t>(text[most]) & 0xc0) == 0x80) --most;
  return text.substr(0, most);
}

// In quotation marks, cut to `most` bytes; control characters and bytes that are not UTF-8 become '?'.
inline std::string quote_text(std::string_view text, std::size_t most = 40) {
  text = cut_text(text, most);
  std::string quoted = "'";
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = get_utf8_length(text, i);
    const bool shown = length > 1 || (length == 1 && text[i] >= 0x20 && text[i] != 0x7f);
    quoted += shown ? std::string(text.substr(i, length)) : "?";
    i += std::max<std::size_t>(1, length);
  }
  return quoted + "'";
}

}  // namespace unlatch::hil
