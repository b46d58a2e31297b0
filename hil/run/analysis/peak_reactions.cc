#include "hil/run/analysis/peak_reactions.h"

#include <algorithm>
#include <cmath>

namespace unlatch::hil {

void PeakReactions::begin(double time, const MultiplierView& multipliers) {
  for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].bounds.take(time, multipliers[i]);
}

void PeakReactions::add(const MotionKnot& from, const MotionKnot& to, bool smooth) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    const double at_from = from.multipliers[i], at_to = to.multipliers[i];
    if (at_from == 0 && at_to == 0) {  // a row without force has no curve
      if (row.loaded) row.bounds.finish();
      row.loaded = false;
      continue;
    }
    // An event may change it where the motion stays smooth.
    const bool begins = !row.loaded || !smooth || at_from != row.latest;
    if (begins) row.bounds.add({from.time, at_from, true});
    row.bounds.add({to.time, at_to, false});
    row.loaded = true;
    row.latest = at_to;
  }
}

PeakReaction PeakReactions::get(std::size_t joint, std::size_t row) const {
  const Row& own = rows_[joint * kRows + row];
  ExtremeBounds bounds = own.bounds;
  if (own.loaded) bounds.finish();
  const ExtremeBounds::Bound &least = bounds.get_low(), &most = bounds.get_high();
  const double low = least.value, high = -most.value;
  if (!std::isfinite(low) || (low == 0 && high == 0)) return {};
  const bool is_low = -low > high;
  PeakReaction peak =
      is_low ? PeakReaction{.value = low, .time = least.found} : PeakReaction{.value = high, .time = most.found};
  const double size = std::abs(peak.value);
  const double smallest = std::max(-least.most, -most.most), largest = std::max(-least.least, -most.least);
  peak.uncertainty = std::max({0.0, size - smallest, largest - size});
  peak.at_ticks = (is_low ? least : most).unsearched < -size;
  return peak;
}

}  // namespace unlatch::hil
