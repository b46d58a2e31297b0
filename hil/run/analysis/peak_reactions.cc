#include "hil/run/analysis/peak_reactions.h"

#include <algorithm>

namespace unlatch::hil {

PeakReactions::PeakReactions(std::size_t joints) : rows_(joints * kRows) {
  for (Knots& knot : knots_) knot.multipliers.resize(rows_.size());
}

void PeakReactions::begin(double time, const MultiplierView& multipliers) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    rows_[i].low.take(time, multipliers[i]);
    rows_[i].high.take(time, -multipliers[i]);
  }
}

void PeakReactions::push(const MotionKnot& knot) {
  Knots& to = get_knot(count_++);
  to.time = knot.time;
  std::copy(knot.multipliers.begin(), knot.multipliers.end(), to.multipliers.begin());
}

double PeakReactions::calc(std::size_t i, std::int64_t first, double time) const {
  double times[kCurvePoints], values[kCurvePoints];
  std::size_t points = 0;
  for (std::int64_t k = std::max(first, count_ - kCurvePoints); k < count_; ++k, ++points) {
    times[points] = get_knot(k).time;
    values[points] = get_knot(k).multipliers[i];
  }
  return interpolate({times, points}, {values, points}, time);
}

void PeakReactions::look_into_latest(std::size_t i, Row& row) const {
  const Knots &from = get_knot(count_ - 2), &to = get_knot(count_ - 1);
  const double at_from = from.multipliers[i], at_to = to.multipliers[i];
  const auto low = [&](double time) { return calc(i, row.first, time); };
  const auto high = [&](double time) { return -calc(i, row.first, time); };
  row.low.look_into(from.time, at_from, to.time, at_to, 0, low);
  row.high.look_into(from.time, -at_from, to.time, -at_to, 0, high);
}

void PeakReactions::add(const MotionKnot& from, const MotionKnot& to, bool smooth) {
  if (!smooth) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].first == kUnloaded) continue;
      look_into_latest(i, rows_[i]);
      rows_[i].first = kUnloaded;
    }
    push(from);
  }
  push(to);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    const double at_from = from.multipliers[i], at_to = to.multipliers[i];
    if (at_from == 0 && at_to == 0) {  // a row without force has no curve
      row.first = kUnloaded;
      continue;
    }
    const bool begins = row.first == kUnloaded;
    if (begins) {
      row.first = count_ - 2;
      get_knot(row.first).multipliers[i] = at_from;  // an event may change it where the motion stays smooth
      row.low.take(from.time, at_from);
      row.high.take(from.time, -at_from);
    }
    row.low.take(to.time, at_to);
    row.high.take(to.time, -at_to);
    if (begins) {
      look_into_latest(i, row);
      continue;
    }
    const Knots &a = get_knot(count_ - 3), &b = get_knot(count_ - 2);
    const double times[3] = {a.time, b.time, to.time};
    const double values[3] = {a.multipliers[i], b.multipliers[i], at_to};
    const double negatives[3] = {-values[0], -values[1], -values[2]};
    row.low.look_about(times, values, 0, [&](double time) { return calc(i, row.first, time); });
    row.high.look_about(times, negatives, 0, [&](double time) { return -calc(i, row.first, time); });
  }
}

PeakReaction PeakReactions::get(std::size_t joint, std::size_t row) const {
  const std::size_t i = joint * kRows + row;
  Row own = rows_[i];
  if (own.first != kUnloaded) look_into_latest(i, own);
  const double low = own.low.get_value(), high = -own.high.get_value();
  if (!own.low.has_value() || (low == 0 && high == 0)) return {};
  return -low > high ? PeakReaction{low, own.low.get_time()} : PeakReaction{high, own.high.get_time()};
}

}  // namespace unlatch::hil
