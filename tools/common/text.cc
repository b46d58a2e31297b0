#include "tools/common/text.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace unlatch::tools {

std::string format(const char* pattern, ...) {
  va_list arguments, again;
  va_start(arguments, pattern);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
  va_end(arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  return text;
}

std::string to_short_text(double value) { return format("%.6g", value); }

std::size_t count_characters(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string to_hex(std::int64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

std::string to_hex(std::uint64_t hash) { return to_hex(static_cast<std::int64_t>(hash)); }

std::string quote_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string get_body_name(const Model& model, int body, const char* ground) {
  return body == kGround ? ground : model.bodies[static_cast<std::size_t>(body)].name;
}

}  // namespace unlatch::tools
