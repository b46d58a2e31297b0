// Estimates by which step.cc locates events within a sub-step: where a guard crosses zero. Times from the beginning of
// the sub-step, s.
#pragma once

namespace unlatch {

// Where some guard crosses first: none has at `from`, one has at `to`. `other`: the end that was replaced last,
// outside.
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

// Zero of the inverse parabola through the three points; of the chord of the bracketing two where these do not rise, or
// the parabola leaves the bracket.
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

}  // namespace unlatch
