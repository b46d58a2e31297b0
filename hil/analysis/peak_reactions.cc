#include "hil/analysis/peak_reactions.h"

namespace unlatch::hil {

void PeakReactions::begin(double time, const MultiplierView& multipliers) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    rows_[i].low.add(time, multipliers[i]);
    rows_[i].high.add(time, -multipliers[i]);
  }
}

void PeakReactions::finish(Row& row) {
  const SampledCurve* curve = &row.curve;
  row.low.finish([curve](double time) { return curve->calc(time); });
  row.high.finish([curve](double time) { return -curve->calc(time); });
}

void PeakReactions::add(const MotionKnot& from, const MotionKnot& to, bool smooth) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    const double at_from = from.multipliers[i], at_to = to.multipliers[i];
    const bool continues = smooth && row.loaded;
    if (row.loaded && !smooth) finish(row);
    row.loaded = at_from != 0 || at_to != 0;  // a row that holds nothing has no curve
    if (!row.loaded) continue;
    if (!continues) row.curve.add(from.time, at_from, true);
    row.curve.add(to.time, at_to, false);
    const SampledCurve* curve = &row.curve;
    row.low.add(from.time, at_from, to.time, at_to, !continues, [curve](double time) { return curve->calc(time); });
    row.high.add(from.time, -at_from, to.time, -at_to, !continues, [curve](double time) { return -curve->calc(time); });
  }
}

PeakReaction PeakReactions::get(std::size_t joint, std::size_t row) const {
  Row own = rows_[joint * kRows + row];
  if (own.loaded) finish(own);
  const double low = own.low.get_value(), high = -own.high.get_value();
  if (!own.low.has_value() || (low == 0 && high == 0)) return {};
  return -low > high ? PeakReaction{low, own.low.get_time()} : PeakReaction{high, own.high.get_time()};
}

}  // namespace unlatch::hil
