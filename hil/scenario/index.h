// An index of a model, which is an int, as that of a vector.
#pragma once

#include <cstddef>

namespace unlatch::hil {

constexpr std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace unlatch::hil
