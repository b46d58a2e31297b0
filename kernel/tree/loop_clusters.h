// Order of elimination of loops: each where its two ways towards the root meet, see
// kernel/solver/loops/loop_clusters.h.
#pragma once

#include "kernel/tree/groups.h"

namespace unlatch {

// Fill of Λ and places of its blocks, for two loops or more without a flexible body on their ways; otherwise nothing,
// and one dense matrix has all their rows. Time and memory: those of one elimination.
void compile_clusters(const LaidOutDraft& draft);

}  // namespace unlatch
