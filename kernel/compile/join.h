// Several models in one that do not touch each other.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "kernel/elements/kinds/kinds.h"
#include "unlatch/model.h"

namespace unlatch {

// Numbers of a model's elements by kind, in the order of their one numbering.
std::array<int, kElementKinds> count_elements(const Model& model);

// The lists of the models one after the other, in their order, and their elements kind by kind. Names begin with the
// number of their model. Gravity, environment and contact_substeps are those of the first. Events that one-sided forces
// need and that a model does not list are added to it first.
Model join_models(std::span<const Model* const> models);

}  // namespace unlatch
