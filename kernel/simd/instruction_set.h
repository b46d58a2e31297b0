// The choice of an instruction set at run time.
#pragma once

#include "unlatch/plan.h"

namespace unlatch {

// kAuto becomes the widest that this build and this processor have.
InstructionSet resolve(InstructionSet set);

}  // namespace unlatch
