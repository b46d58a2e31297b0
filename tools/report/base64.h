// RFC 4648, with padding.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace unlatch::tools {

[[nodiscard]] std::string to_base64(std::span<const std::uint8_t> bytes);

}  // namespace unlatch::tools
