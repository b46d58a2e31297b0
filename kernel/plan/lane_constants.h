// The constants of bodies, joints and solver, in the lanes that compile_lanes() has given them.
#pragma once

#include "unlatch/plan.h"

namespace unlatch {

// Fills Plan::body_constants, joint_constants and solver_constants.
void fill_constants(const Model& model, Plan& plan);

}  // namespace unlatch
