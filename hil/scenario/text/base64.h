// Base64 of RFC 4648, with padding.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace unlatch::hil {

[[nodiscard]] std::string to_base64(std::span<const std::uint8_t> bytes);
// Decodes a text. Absent if `text` is not exactly the encoding of some bytes.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace unlatch::hil
