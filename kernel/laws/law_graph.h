// LawGraph: which law reads which, and which of them forces read.
#pragma once

#include <vector>

#include "unlatch/model.h"

namespace unlatch {

struct LawGraph {
  std::vector<int> order;     // all laws, each behind those that it reads
  std::vector<bool> driving;  // per law: some force reads it, or a law that a force reads
  std::vector<int> circle;    // laws that depend on themselves; where there are any, the rest is not valid
};

// How many numbers of Evaluation::law_places a step of a law has: the coordinates of a table, what decides a branch.
int count_law_places(const Model& model, const LawStep& step);

// Per law the bodies whose air it is the first to read, of laws that forces read. Their altitudes have a place each in
// Evaluation::law_places, behind those of the law's steps.
std::vector<std::vector<int>> list_air_bodies(const Model& model, const std::vector<bool>& driving);

// Indices in laws must exist; those in elements need not.
LawGraph build_law_graph(const Model& model);

}  // namespace unlatch
