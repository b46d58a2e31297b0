// From a draft to a plan: its image.
#pragma once

#include "kernel/plan/plan_data.h"

namespace unlatch {

// The plan owns its image. Equal drafts have equal images, byte by byte.
Plan build_plan(const PlanDraft& draft);

}  // namespace unlatch
