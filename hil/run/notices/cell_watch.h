// CellWatch: cells of tables that a motion skips from one tick to the next. What a table has there acts on no stage of
// the step, or on one by chance: the bodies that it pushes are unresolved.
#pragma once

#include <span>
#include <vector>

#include "unlatch/model.h"
#include "unlatch/model/law_places.h"

namespace unlatch::hil {

struct SkippedCells {
  int table = 0, axis = 0;      // indices of the model
  double cells = 0;             // whole ones between both places
  double from = 0, to = 0;      // places, in the unit of the axis
  std::span<const int> bodies;  // that a force by this table pushes
};

class CellWatch {
 public:
  explicit CellWatch(const Model& model);

  // Of the step that ends with these places (get_law_places()); of the first call none. Valid until the next call.
  // `jumps`: events acted in the step, so that times since them began anew.
  // A linear table is followed from knot to knot within a step, up to kMostCorners of them. An angle that jumps by a
  // turn, from one end of a fine axis to the other, skips nothing.
  std::span<const SkippedCells> update(std::span<const double> places, bool jumps);

 private:
  struct Watched {
    TableLookup lookup;
    std::vector<int> bodies;
  };

  const Model& model_;
  std::vector<Watched> watched_;  // look-ups of laws that forces read
  std::vector<double> places_;    // of the latest tick
  std::vector<SkippedCells> skipped_;
};

}  // namespace unlatch::hil
