// Estimates by which event_search.cc locates events within a sub-step: where a guard crosses zero, and how high a guard
// rises that is below zero at both ends. Times are from the beginning of the sub-step, s.
#pragma once

#include <cmath>

namespace unlatch {

// Interval that contains the earliest crossing: no guard has crossed at `from`, one has at `to`. `other`: the end that
// was replaced last, outside of it.
struct Bracket {
  double from, to, other;
  bool narrowed = false;  // there is an `other`

  // The bracket without what lies beyond `time`, or before it.
  void narrow(double time, bool has_crossed) {
    double& end = has_crossed ? to : from;
    other = end;
    end = time;
    narrowed = true;
  }
};

struct Crossing {
  double time;
  bool sure;  // by three values that rise with time
};

// Zero of the inverse parabola through the three points; where they do not rise, or the parabola leaves the bracket,
// that of the chord between its ends.
inline Crossing interpolate(const Bracket& b, double at_from, double at_to, double at_other) {
  const double chord = b.from + (b.to - b.from) * (at_from / (at_from - at_to));
  if (!b.narrowed) return {chord, false};
  const bool before = b.other < b.from;
  const double start = before ? b.other : b.from, x = (before ? b.from : b.to) - start,
               h = (before ? b.to : b.other) - start;
  const double low = before ? at_other : at_from, middle = before ? at_from : at_to, high = before ? at_to : at_other;
  if (!(low < middle && middle < high)) return {chord, false};
  const double parabola = start + (x * (low * high) / ((middle - low) * (middle - high)) +
                                   h * (low * middle) / ((high - low) * (high - middle)));
  return parabola > b.from && parabola < b.to ? Crossing{parabola, true} : Crossing{chord, false};
}

// One end of an interval: a function and its rate.
struct Flank {
  double time, value, rate;
};

// Time after `left` at which the tangents at both ends intersect, of a function that rises at `left`, falls at `right`.
inline double calc_meeting(const Flank& left, const Flank& right) {
  const double h = right.time - left.time;
  return ((right.value - left.value) - right.rate * h) / (left.rate - right.rate);
}

// Upper bound between the two of a concave function: it stays below its tangents.
inline double calc_bound(const Flank& left, const Flank& right) {
  return left.value + left.rate * calc_meeting(left, right);
}

// True if a function that is below zero at both ends, rises at `left` and falls at `right` may reach zero in between:
// its tangents intersect above zero.
inline bool may_peak(const Flank& left, const Flank& right) {
  if (!(left.rate > 0 && right.rate < 0 && left.value < 0 && right.value < 0)) return false;
  const double meeting = calc_meeting(left, right);
  return meeting > 0 && meeting < right.time - left.time && calc_bound(left, right) >= 0;
}

// Time at which the cubic through both flanks is greatest, within the inner seven eighths of the interval.
inline double calc_peak(const Flank& left, const Flank& right) {
  const double h = right.time - left.time, rise = 6 * (right.value - left.value);
  const double first = h * left.rate, last = h * right.rate;
  // Its rate at the part s of the interval: first + b s + c s².
  const double b = (rise - 4 * first) - 2 * last, c = 3 * (first + last) - rise;
  const double s = 2 * first / (std::sqrt(b * b - 4 * c * first) - b);
  constexpr double kInner = 1.0 / 16;
  return left.time + h * (s > kInner ? (s < 1 - kInner ? s : 1 - kInner) : kInner);
}

// Likewise of a line from one flank on that goes over into a parabola which ends at the other: beside a corner of the
// curvature, as where a shape passes the rounded end of another, the cubic stays near the flank of the line. Of the two
// such curves one has its corner within the interval.
inline double calc_bent_peak(const Flank& left, const Flank& right) {
  const double h = right.time - left.time, bend = left.rate - right.rate;     // bend > 0
  const double bent = 2 * (left.value + left.rate * h - right.value) / bend;  // length of a parabola that ends at right
  const double other = 2 * h - bent;                                          // of one that ends at left
  const double part = left.rate / bend;                                       // of the parabola, up to its peak
  const double peak = bent <= h ? (h - bent) + bent * part : other * part;
  constexpr double kInner = 1.0 / 16;
  return left.time + (peak > kInner * h ? (peak < (1 - kInner) * h ? peak : (1 - kInner) * h) : kInner * h);
}

}  // namespace unlatch
