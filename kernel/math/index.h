// Indices are ints, so that kNone and differences are plain; containers want std::size_t.
#pragma once

#include <cstddef>

namespace unlatch {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace unlatch
