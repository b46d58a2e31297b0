// Where the laws of a model look tables up, while it moves.
#pragma once

#include <span>
#include <vector>

#include "unlatch/model.h"
#include "unlatch/workspace.h"

namespace unlatch {

// One look-up of a table by a law.
struct TableLookup {
  int law = 0, table = 0;  // indices of the model
  int place = 0;           // of its first coordinate in get_law_places(); those of the other axes follow
};
// Of all laws of a valid model, in their order.
std::vector<TableLookup> list_table_lookups(const Model& model);

// Ways in which an element reads a law.
enum class Reading {
  kDirect,  // its size or coefficient is the law
  kAny,     // directly, or through other laws
};
// Per law of a valid model, the bodies of the elements that read it; without the ground.
std::vector<std::vector<int>> list_bodies_of_laws(const Model& model, Reading reading = Reading::kAny);

// The laws that `law` reads, directly or through others, each behind those that it reads; `law` itself is the last.
std::vector<int> list_laws_behind(const Model& model, int law);

// True if a law of a valid model that some element reads has a table or a branch, or reads the air, or if the air acts
// on a body: at such corners a step may be split.
bool has_driving_corners(const Model& model);

// Where the laws looked tables up at the end of the latest step.
std::span<const double> get_law_places(const Workspace& workspace) noexcept;

// Knots of one axis that a sub-step may pass: at each, linear tables split it, so that no corner lies inside. Of finer
// tables, and beyond this, it passes the cells.
inline constexpr int kMostCorners = 4;

}  // namespace unlatch
