// Conversion of a model's indices, which are ints, to those of vectors and to the common numbering of elements.
#pragma once

#include <cstddef>

#include "unlatch/model.h"

namespace unlatch::hil {

constexpr std::size_t at(int index) { return static_cast<std::size_t>(index); }

// Number, as in State::elements, of the model's first one-sided force; the others follow it.
inline int get_first_one_sided(const Model& model) {
  return model.element_count() - static_cast<int>(model.frictions.size() + model.one_sided.size());
}

}  // namespace unlatch::hil
