#include "hil/run/motion/shape_dips.h"

#include <algorithm>
#include <cmath>

#include "hil/run/motion/extreme.h"

namespace unlatch::hil {
namespace {

// Searches for the dips of a function that may have several, from samples.
void sample(double from, double at_from, double to, double at_to, int count, double resolution,
            const TimeFunction& function, Least& least) {
  double times[3] = {from, from, from}, values[3] = {at_from, at_from, at_from};
  for (int i = 1; i <= count + 1; ++i) {
    std::copy(times + 1, times + 3, times);
    std::copy(values + 1, values + 3, values);
    times[2] = i <= count ? from + (to - from) * i / (count + 1) : to;
    values[2] = i <= count ? function(times[2]) : at_to;
    least.take(times[2], values[2]);
    if (i > 1) least.look_about(times, values, resolution, function);
  }
}

// Samples of a pair whose distance departs from a line by at most `way` within the piece. What is shallower than
// kShallow of the shapes is left to the knots.
int count_samples(double way, double size) {
  constexpr double kShallow = 1e-3, kFine = 0.05;
  constexpr int kMost = 32;
  if (!(size > 0) || !(way > kShallow * size)) return 0;
  return way < kMost * kFine * size ? 1 + static_cast<int>(way / (kFine * size)) : kMost;
}

}  // namespace

std::optional<Dip> find_dip(const ClearanceMonitor& monitor, const MotionPiece& piece, const DipSearch& search) {
  const std::vector<ClearanceMonitor::ShapePair>& pairs = monitor.get_shape_pairs(search.pair);
  if (pairs.empty() || !(piece.to > piece.from)) return {};
  const auto place = [&](std::size_t body, double time) { return to_placement(piece.calc_body(body, time)); };
  const geometry::Placement from_a = to_placement(piece.start[search.a]), from_b = to_placement(piece.start[search.b]);
  const geometry::Placement to_a = to_placement(piece.end[search.a]), to_b = to_placement(piece.end[search.b]);
  Least least;
  const auto get_limit = [&] { return std::min(search.limit, least.get_value()); };
  for (const ClearanceMonitor::ShapePair& shapes : pairs) {
    // Within the piece the distance is at least the mean of both ends less half of the way.
    const double bound =
        monitor.calc_lower_bound(shapes, from_a, from_b) + monitor.calc_lower_bound(shapes, to_a, to_b);
    if (0.5 * (bound - search.length) >= get_limit()) continue;
    const auto function = [&](double time) {
      return monitor.calc_distance(shapes, place(search.a, time), place(search.b, time));
    };
    const double at_from = monitor.calc_distance(shapes, from_a, from_b);
    const double at_to = monitor.calc_distance(shapes, to_a, to_b);
    const double way = 0.5 * (search.length - std::abs(at_from - at_to));
    if (std::min(at_from, at_to) - way >= get_limit()) continue;
    if (shapes.convex)
      least.look_into(piece.from, at_from, piece.to, at_to, search.resolution, function);
    else
      sample(piece.from, at_from, piece.to, at_to, count_samples(way, shapes.size), search.resolution, function, least);
  }
  if (!(least.get_value() < search.limit - search.resolution)) return {};
  return Dip{least.get_time(), least.get_value()};
}

}  // namespace unlatch::hil
