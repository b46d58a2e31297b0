// One number for everything in a model that decides its motion, the same on every machine.
#pragma once

#include <cstdint>

#include "unlatch/plan.h"

namespace unlatch {

std::uint64_t calc_model_hash(const Model& model, const PlanOptions& options);

}  // namespace unlatch
