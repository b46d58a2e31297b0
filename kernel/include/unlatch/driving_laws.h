// Laws of a model that its forces read.
#pragma once

#include <vector>

#include "unlatch/model.h"

namespace unlatch {

// Per law of a valid model: some force reads it, or a law that a force reads.
std::vector<bool> list_driving_laws(const Model& model);

}  // namespace unlatch
