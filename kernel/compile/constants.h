// Constants of the blocks: BodyConstants, JointConstants, RotationConstants and SolverConstants (blocks.h).
#pragma once

#include "kernel/tree/groups.h"

namespace unlatch {

void fill_constants(const Model& model, const LaidOutDraft& draft);

}  // namespace unlatch
