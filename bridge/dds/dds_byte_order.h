// Samples in the other byte order are refused where Cyclone DDS cannot read them safely.
#pragma once

namespace unlatch::bridge {

// True if that is so in this program. Names the function, so that a static library's user gets it linked.
[[nodiscard]] bool is_byte_order_checked() noexcept;

}  // namespace unlatch::bridge
