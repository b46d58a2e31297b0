// The two kinds of lists of a plan.
#pragma once

#include <span>
#include <vector>

namespace unlatch {

// Of a plan to step with: a view of its image.
template <class T>
using FixedList = std::span<const T>;

// Of a plan while it is compiled.
template <class T>
using GrowingList = std::vector<T>;

}  // namespace unlatch
