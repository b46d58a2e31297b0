// The Sobol' sequence, from Boost.Random. Its headers are slow to compile: only sobol.cc includes them.
#pragma once

#include <cstdint>
#include <vector>

namespace unlatch::hil {

// Element `index` of the sequence, 64 bits of each coordinate. Throws for more dimensions than its table has (3,667).
std::vector<std::uint64_t> calc_sobol(std::size_t dimensions, std::uint64_t index);

}  // namespace unlatch::hil
