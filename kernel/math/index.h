// Conversion of indices, which are ints because of kNone and differences, to those of containers.
#pragma once

#include <cstddef>

namespace unlatch {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace unlatch
