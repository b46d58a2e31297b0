#include "hil/run/motion/shape_dips.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "hil/run/motion/extreme.h"
#include "hil/run/motion/relative_motion.h"

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

using geometry::Extent;

constexpr double kEver = std::numeric_limits<double>::infinity();

// A point of the reach that moves with `seen`, as seen from the body `from`: bounds on its velocity along the axes of
// `from`, and on how that changes.
struct SeenSpeed {
  Vec3 along{0, 0, 0};  // m/s
  double change = 0;    // m/s²
};
SeenSpeed calc_seen_speed(const ClearanceMonitor::Reach& reach, const MovingBody& from, const MovingBody& seen) {
  const Vec3 arm = seen.at.R_WB * reach.centre, between = (seen.at.p_WB + arm) - from.at.p_WB, turn = seen.w - from.w;
  const Vec3 v = ((seen.v + cross(seen.w, arm)) - from.v) - cross(from.w, between);
  const Vec3 in_from = transpose_times(from.at.R_WB, v);
  const double turning = reach.bound * norm(turn), turns = norm(from.w) + norm(turn);
  const double far = norm(between) + norm(arm) + reach.bound;
  const auto& [a, b] = std::pair(from.acceleration, seen.acceleration);
  return {{std::abs(in_from.x) + turning, std::abs(in_from.y) + turning, std::abs(in_from.z) + turning},
          norm(b.lin - a.lin) + (norm(a.ang) + norm(b.ang) + turns * turns) * far + 2 * turns * (norm(v) + turning)};
}

// The ways of such points along each axis within the piece, m: at most these.
Vec3 calc_ways(const SeenSpeed& from, const SeenSpeed& to, double h) {
  const double bend = std::max(from.change, to.change) * h * h;
  return {std::max(from.along.x, to.along.x) * h + bend, std::max(from.along.y, to.along.y) * h + bend,
          std::max(from.along.z, to.along.z) * h + bend};
}

// The boxes about single shapes of both sides wherever they get within a piece, in the axes of one of the bodies.
class Swept {
 public:
  Swept(const ClearanceMonitor& monitor, const MotionPiece& piece, const DipSearch& search) {
    const ClearanceMonitor::Reach& reach = monitor.get_reach(search.pair);
    of_b_ = reach.of_b;
    const std::vector<geometry::ShapeGroup>&a = monitor.get_shapes_a(search.pair),
          &b = monitor.get_shapes_b(search.pair);
    for (const geometry::ShapeGroup& shape : of_b_ ? a : b) still_.push_back(geometry::calc_extent(shape, {}));
    moving_.assign((of_b_ ? b : a).size(), {{-kEver, -kEver, -kEver}, {kEver, kEver, kEver}});
    if (!std::isfinite(reach.bound)) return;
    const std::size_t from = of_b_ ? search.a : search.b, seen = of_b_ ? search.b : search.a;
    const MovingBody begin_from = get_moving_body(piece.start[from], piece.at_start[from]),
                     begin_seen = get_moving_body(piece.start[seen], piece.at_start[seen]),
                     end_from = get_moving_body(piece.end[from], piece.at_end[from]),
                     end_seen = get_moving_body(piece.end[seen], piece.at_end[seen]);
    const Vec3 around = 0.5 * calc_ways(calc_seen_speed(reach, begin_from, begin_seen),
                                        calc_seen_speed(reach, end_from, end_seen), piece.to - piece.from);
    const geometry::Placement begin = see(begin_from.at, begin_seen.at), end = see(end_from.at, end_seen.at);
    for (std::size_t i = 0; i < moving_.size(); ++i) {  // a face of a box goes half of the way from its mean at most
      const geometry::ShapeGroup& shape = (of_b_ ? b : a)[i];
      const Extent first = geometry::calc_extent(shape, begin), last = geometry::calc_extent(shape, end);
      moving_[i] = {0.5 * (first.least + last.least) - around, 0.5 * (first.most + last.most) + around};
    }
  }
  // m, by which the boxes of two shapes are apart at least; below 0 they overlap by no more.
  [[nodiscard]] double calc_gap(const ClearanceMonitor::ShapePair& shapes) const {
    const Extent &still = still_[of_b_ ? shapes.a : shapes.b], &moving = moving_[of_b_ ? shapes.b : shapes.a];
    const Vec3 left = still.least - moving.most, right = moving.least - still.most;
    return std::max({left.x, right.x, left.y, right.y, left.z, right.z});
  }

 private:
  static geometry::Placement see(const geometry::Placement& from, const geometry::Placement& seen) {
    const Mat3 &R = from.R_WB, &S = seen.R_WB;
    return {transpose_times(R, seen.p_WB - from.p_WB),
            {transpose_times(R, S.x), transpose_times(R, S.y), transpose_times(R, S.z)}};
  }

  bool of_b_ = true;
  std::vector<Extent> still_, moving_;
};

// What a distance may be below the gap of two boxes, of the pair's size: rounding, and how exact the depth of an
// overlap is (kernel/geometry/README.md).
double calc_inexact(double gap) { return gap > 0 ? 1e-9 : 2e-5; }

}  // namespace

std::optional<Dip> find_dip(const ClearanceMonitor& monitor, const MotionPiece& piece, const DipSearch& search) {
  const std::vector<ClearanceMonitor::ShapePair>& pairs = monitor.get_shape_pairs(search.pair);
  if (pairs.empty() || !(piece.to > piece.from)) return {};
  const auto place = [&](std::size_t body, double time) { return to_placement(piece.calc_body(body, time)); };
  const geometry::Placement from_a = to_placement(piece.start[search.a]), from_b = to_placement(piece.start[search.b]);
  const geometry::Placement to_a = to_placement(piece.end[search.a]), to_b = to_placement(piece.end[search.b]);
  Least least;
  const auto get_limit = [&] { return std::min(search.limit, least.get_value()); };
  const Swept swept(monitor, piece, search);
  const double size = monitor.get_size(search.pair);
  for (const ClearanceMonitor::ShapePair& shapes : pairs) {
    const double gap = swept.calc_gap(shapes);
    if (gap - calc_inexact(gap) * size >= get_limit()) continue;
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
