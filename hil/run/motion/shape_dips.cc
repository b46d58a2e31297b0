#include "hil/run/motion/shape_dips.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "hil/run/motion/extreme.h"
#include "hil/run/motion/motion_bend.h"
#include "unlatch/geometry/reach.h"

namespace unlatch::hil {
namespace {

using geometry::Extent;
using ShapePair = ClearanceMonitor::ShapePair;

constexpr double kEver = std::numeric_limits<double>::infinity();

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

// Depth up to which two shapes overlap with cores that are apart; two polytopes are exact at any depth.
double calc_exact_depth(const geometry::ShapeGroup& a, const geometry::ShapeGroup& b) {
  const double of_a = geometry::get_exact_depth(a), of_b = geometry::get_exact_depth(b);
  if (std::isinf(of_a) && std::isinf(of_b)) return kEver;
  return (std::isinf(of_a) ? 0 : of_a) + (std::isinf(of_b) ? 0 : of_b);
}

// Place of a body as seen from another.
geometry::Placement see(const geometry::Placement& from, const geometry::Placement& seen) {
  const Mat3 &R = from.R_WB, &S = seen.R_WB;
  return {transpose_times(R, seen.p_WB - from.p_WB),
          {transpose_times(R, S.x), transpose_times(R, S.y), transpose_times(R, S.z)}};
}

bool is_same_place(const BodyState& a, const BodyState& b) {
  return a.p.x == b.p.x && a.p.y == b.p.y && a.p.z == b.p.z && a.q.w == b.q.w && a.q.x == b.q.x && a.q.y == b.q.y &&
         a.q.z == b.q.z;
}

}  // namespace

// Both ends of the present piece. One side of the pair is still: all is seen from its body.
class ShapeDips::Memory {
 public:
  Memory(const ClearanceMonitor& monitor, std::size_t pair, std::size_t a, std::size_t b)
      : pair_(pair), a_(a), b_(b), size_(monitor.get_size(pair)) {
    const ClearanceMonitor::Reach& reach = monitor.get_reach(pair);
    of_b_ = reach.of_b;
    reach_ = norm(reach.centre) + reach.bound;
    const std::vector<geometry::ShapeGroup>&of_a = monitor.get_shapes_a(pair), &of_b = monitor.get_shapes_b(pair);
    for (const geometry::ShapeGroup& shape : of_b_ ? of_a : of_b) still_.push_back(geometry::calc_extent(shape, {}));
    const std::size_t moving = (of_b_ ? of_b : of_a).size();
    for (Knot& knot : ends_) knot.extents.resize(moving);
    swept_.resize(moving);
    for (std::vector<double>* numbers : {&change_, &way_, &far_}) numbers->resize(moving);
    for (const ShapePair& shapes : monitor.get_shape_pairs(pair)) {
      const geometry::ShapeGroup &one = of_a[shapes.a], &other = of_b[shapes.b];
      Of& of = of_.emplace_back();
      of.deep = calc_exact_depth(one, other);
      // How exact a certified distance is, and the depth of an overlap (kernel/geometry/README.md).
      of.apart = 1e-9 * size_;
      of.overlap = of.apart + 2e-5 * (2 * (one.bound + other.bound));
      convex_ = convex_ && shapes.convex;
    }
    convex_ = convex_ && !of_.empty();
  }

  // Moves to a piece of motion, if it is another one.
  void move_on(const ClearanceMonitor& monitor, const MotionPiece& piece) {
    if (is_of(piece)) return;
    before_ = {};
    ++number_;
    continues_ = known_ && is_at(piece.start, ends_[1]);
    if (continues_) {
      before_ = {.from = from_, .to = to_, .bend = bend_, .is_sorted = sorted_};
      std::swap(ends_[0], ends_[1]);
    } else {
      place(monitor, piece.start, ends_[0]);
      sorted_ = false;
    }
    place(monitor, piece.end, ends_[1]);
    known_ = true;
    from_ = piece.from;
    to_ = piece.to;
    // A corner of the box about a shape is no farther from its middle than √3 of its radius.
    constexpr double kCorner = 1.7320508075688773;
    bend_ = calc_bend(piece, of_b_ ? a_ : b_, of_b_ ? b_ : a_, kCorner * reach_);
    for (std::size_t i = 0; i < swept_.size(); ++i) {
      const Extent &begin = ends_[0].extents[i], &end = ends_[1].extents[i];
      const Vec3 around{bend_, bend_, bend_};
      swept_[i] = {Vec3{std::min(begin.least.x, end.least.x), std::min(begin.least.y, end.least.y),
                        std::min(begin.least.z, end.least.z)} -
                       around,
                   Vec3{std::max(begin.most.x, end.most.x), std::max(begin.most.y, end.most.y),
                        std::max(begin.most.z, end.most.z)} +
                       around};
      change_[i] = std::max(calc_change(begin.least, end.least), calc_change(begin.most, end.most));
      way_[i] += change_[i];
      constexpr double kMostWay = 100;  // of the size: until then its rounding is small beside Of::apart
      sorted_ = sorted_ && way_[i] < kMostWay * size_;
    }
    tried_ = -kEver;
  }
  [[nodiscard]] bool is_of(const MotionPiece& piece) const {
    return known_ && piece.from == from_ && piece.to == to_ && is_at(piece.start, ends_[0]) &&
           is_at(piece.end, ends_[1]);
  }

  // Pairs of shapes, in order, without those whose boxes are so far apart within the piece that no distance of theirs
  // is below `limit`. Far ones are found once, and their boxes' ways counted from then on.
  const std::vector<std::size_t>& list_near(const std::vector<ShapePair>& pairs, double limit) {
    if (sorted_ && is_far(limit, bend_)) return near_;
    if (limit > tried_) sort(pairs, limit);
    return is_far(limit, bend_) ? near_ : all_;
  }
  // Likewise in the piece before, if that is known of this one; null if it is not.
  [[nodiscard]] const std::vector<std::size_t>* find_near_before(const MotionPiece& before, double limit) const {
    const bool is_known = before_.is_sorted && before_.from == before.from && before_.to == before.to;
    return is_known && is_far(limit, std::max(before_.bend, bend_)) ? &near_ : nullptr;
  }

  // Place of the moving body as seen from the other.
  [[nodiscard]] geometry::Placement see_moving(const geometry::Placement& a, const geometry::Placement& b) const {
    return of_b_ ? see(a, b) : see(b, a);
  }
  // True if the plane that parted the two lately parts them so far where the moving body is `seen`.
  [[nodiscard]] bool is_parted_at(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes,
                                  const geometry::Placement& seen, double limit) const {
    return of_[i].has_plane && take_off(i, calc_slab(monitor, i, shapes, seen)) >= limit;
  }

  // True if the boxes about the two shapes, wherever they get, are so far apart.
  [[nodiscard]] bool is_beyond(std::size_t i, const ShapePair& shapes, double limit) const {
    const Extent &still = still_[of_b_ ? shapes.a : shapes.b], &moving = swept_[of_b_ ? shapes.b : shapes.a];
    return take_off(i, calc_gap(still, moving)) >= limit;
  }

  // True if the plane that parted the two lately keeps them so far apart.
  [[nodiscard]] bool is_parted(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes, double limit) {
    if (!of_[i].has_plane) return false;
    for (const std::size_t end : {1U, 0U})
      if (!(take_off(i, get_slab(monitor, i, shapes, end) - bend_) >= limit)) return false;
    return true;
  }

  // False only if that plane shows that the distance does not descend into the piece from one of its ends, so far as
  // Least::look_into() sees. `at_from`, `at_to`: the distances there.
  [[nodiscard]] bool may_dip(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes, double at_from,
                             double at_to, double resolution) {
    if (!of_[i].has_plane) return true;
    const double from = get_slab(monitor, i, shapes, 0), to = get_slab(monitor, i, shapes, 1), part = Least::kNear;
    const auto descends = [&](double near, double far, double value) {
      const double slab = ((1 - part) * near + part * far) - calc_bend_near_end(bend_, part);
      return !(take_off(i, slab) >= value - resolution);
    };
    return descends(to, from, at_to) && descends(from, to, at_from);
  }

  // Distance at an end of the piece; of convex shapes, with a plane that parts them there.
  double calc_value(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes, std::size_t end) {
    Of& of = get_present(i);
    if (is_known(of.value[end])) return of.value[end];
    const geometry::Distance found = monitor.calc_pair(shapes, ends_[end].at_a, ends_[end].at_b);
    of.value[end] = found.distance;
    if (!shapes.convex) return found.distance;
    const Mat3& R = (of_b_ ? ends_[end].at_a : ends_[end].at_b).R_WB;
    of.normal = transpose_times(R, of_b_ ? found.normal : -found.normal);
    const geometry::ShapeGroup& still =
        of_b_ ? monitor.get_shapes_a(pair_)[shapes.a] : monitor.get_shapes_b(pair_)[shapes.b];
    of.still = geometry::calc_reach(still, {}, of.normal);
    of.has_plane = std::isfinite(of.still);
    of.slab[0] = of.slab[1] = kUnknown;
    return found.distance;
  }
  // True if the boxes, or that plane, show that no distance below `limit` can be computed at the end of the piece.
  [[nodiscard]] bool is_apart_at_end(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes,
                                     double limit) {
    if (const double value = get_present(i).value[1]; is_known(value)) return value >= limit;
    const Extent &still = still_[of_b_ ? shapes.a : shapes.b], &moving = ends_[1].extents[of_b_ ? shapes.b : shapes.a];
    return take_off(i, calc_gap(still, moving)) >= limit ||
           (of_[i].has_plane && take_off(i, get_slab(monitor, i, shapes, 1)) >= limit);
  }
  // Takes a distance at an end that is known already.
  void take_value(std::size_t i, std::size_t end, double value) { get_present(i).value[end] = value; }

  [[nodiscard]] bool is_convex() const { return convex_; }
  // The pair of shapes that was nearest the last time.
  [[nodiscard]] std::size_t get_nearest() const { return nearest_; }
  void set_nearest(std::size_t i) { nearest_ = i; }
  [[nodiscard]] std::size_t get_pair() const { return pair_; }
  [[nodiscard]] std::size_t get_a() const { return a_; }
  [[nodiscard]] std::size_t get_b() const { return b_; }

 private:
  static constexpr double kUnknown = -kEver;  // no distance of shapes is
  static bool is_known(double value) { return value > kUnknown; }

  struct Knot {
    BodyState a{}, b{};
    geometry::Placement at_a{}, at_b{}, seen{};
    std::vector<Extent> extents;  // of the shapes that move, as seen
  };
  // Of a pair of shapes.
  struct Of {
    Vec3 normal{0, 0, 0};           // of the plane, from the still shape to the other, as seen
    double still = 0;               // m, reach of the still shape
    bool has_plane = false;         //
    std::int64_t number = 0;        // of the piece that these are of
    double slab[2]{}, value[2]{};   // m, at both ends: across the plane, and the distance
    double apart = 0, overlap = 0;  // m, what a computed distance may be below the widest slab; the latter where it
    double deep = 0;                // is a depth beyond this, m
  };

  // With what is known of it at the ends of the present piece; most pairs of shapes are never asked for.
  Of& get_present(std::size_t i) {
    Of& of = of_[i];
    if (of.number == number_) return of;
    const bool is_before = continues_ && of.number + 1 == number_;
    of.slab[0] = is_before ? of.slab[1] : kUnknown;
    of.value[0] = is_before ? of.value[1] : kUnknown;
    of.slab[1] = of.value[1] = kUnknown;
    of.number = number_;
    return of;
  }
  [[nodiscard]] bool is_at(std::span<const BodyState> bodies, const Knot& knot) const {
    return is_same_place(bodies[a_], knot.a) && is_same_place(bodies[b_], knot.b);
  }
  void place(const ClearanceMonitor& monitor, std::span<const BodyState> bodies, Knot& knot) const {
    knot.a = bodies[a_];
    knot.b = bodies[b_];
    knot.at_a = to_placement(knot.a);
    knot.at_b = to_placement(knot.b);
    knot.seen = see_moving(knot.at_a, knot.at_b);
    const std::vector<geometry::ShapeGroup>& moving = of_b_ ? monitor.get_shapes_b(pair_) : monitor.get_shapes_a(pair_);
    for (std::size_t i = 0; i < moving.size(); ++i) knot.extents[i] = geometry::calc_extent(moving[i], knot.seen);
  }
  // Width across the plane at an end, m.
  double get_slab(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes, std::size_t end) {
    Of& of = get_present(i);
    if (is_known(of.slab[end])) return of.slab[end];
    return of.slab[end] = calc_slab(monitor, i, shapes, ends_[end].seen);
  }
  [[nodiscard]] double calc_slab(const ClearanceMonitor& monitor, std::size_t i, const ShapePair& shapes,
                                 const geometry::Placement& seen) const {
    const geometry::ShapeGroup& moving =
        of_b_ ? monitor.get_shapes_b(pair_)[shapes.b] : monitor.get_shapes_a(pair_)[shapes.a];
    return -geometry::calc_reach(moving, seen, -of_[i].normal) - of_[i].still;
  }
  static double calc_change(const Vec3& a, const Vec3& b) {
    return std::max({std::abs(b.x - a.x), std::abs(b.y - a.y), std::abs(b.z - a.z)});
  }
  // Width of the slab between two boxes, m.
  static double calc_gap(const Extent& a, const Extent& b) {
    const Vec3 left = a.least - b.most, right = b.least - a.most;
    return std::max({left.x, right.x, left.y, right.y, left.z, right.z});
  }
  [[nodiscard]] bool is_far(double limit, double bend) const {
    for (std::size_t s = 0; s < far_.size(); ++s)
      if (!(far_[s] - way_[s] - bend >= limit)) return false;
    return true;
  }
  // Far pairs are those whose boxes stay apart for some more pieces such as this.
  void sort(const std::vector<ShapePair>& pairs, double limit) {
    constexpr double kPieces = 16;
    near_.clear();
    all_.resize(pairs.size());
    std::iota(all_.begin(), all_.end(), std::size_t{0});
    std::fill(far_.begin(), far_.end(), kEver);
    std::fill(way_.begin(), way_.end(), 0.0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const std::size_t s = of_b_ ? pairs[i].b : pairs[i].a;
      const double gap = calc_gap(still_[of_b_ ? pairs[i].a : pairs[i].b], ends_[1].extents[s]);
      const double least = (gap - of_[i].apart) - change_[s];  // anywhere within this piece, but for its bend
      if (gap > 0 && least > limit + kPieces * (change_[s] + bend_))
        far_[s] = std::min(far_[s], least);
      else
        near_.push_back(i);
    }
    sorted_ = true;
    before_.is_sorted = false;  // boxes were measured at the end of this piece
    tried_ = limit;
  }
  // Least distance that may be computed, of a slab.
  [[nodiscard]] double take_off(std::size_t i, double slab) const {
    return slab - (slab > -of_[i].deep ? of_[i].apart : of_[i].overlap);
  }

  std::size_t pair_, a_, b_;
  double size_;
  bool of_b_ = true;
  double reach_ = 0;  // m, from the moving body's origin
  bool known_ = false;
  std::int64_t number_ = 0;  // of the present piece, from 1 on
  bool continues_ = false;   // it begins where the one before ended
  double from_ = 0, to_ = 0, bend_ = 0;
  // The piece that this one continues; sorted: far pairs were known in it, by the same boxes as in this one.
  struct Before {
    double from = 0, to = 0, bend = 0;
    bool is_sorted = false;
  };
  Before before_;
  Knot ends_[2];
  std::vector<Extent> still_, swept_;
  std::vector<Of> of_;
  // Of far pairs, by moving shape: change of its box within the piece, and its way since they were sorted out; the
  // least of their bounds then, m.
  std::vector<double> change_, way_, far_;
  std::vector<std::size_t> near_, all_;
  bool sorted_ = false;    // far pairs are known
  double tried_ = -kEver;  // m, limit for which they were sorted out within this piece
  bool convex_ = true;     // all shapes are
  std::size_t nearest_ = 0;
};

ShapeDips::ShapeDips(const ClearanceMonitor& monitor, std::size_t pair, std::size_t a, std::size_t b, Skipping skipping)
    : memory_(std::make_unique<Memory>(monitor, pair, a, b)), skipping_(skipping) {}
ShapeDips::~ShapeDips() = default;
ShapeDips::ShapeDips(ShapeDips&&) noexcept = default;
ShapeDips& ShapeDips::operator=(ShapeDips&&) noexcept = default;

bool ShapeDips::stays_above(const ClearanceMonitor& monitor, const MotionPiece& piece, double limit) {
  Memory& memory = *memory_;
  const std::vector<ShapePair>& pairs = monitor.get_shape_pairs(memory.get_pair());
  if (skipping_ == Skipping::kOff || pairs.empty() || !(piece.to > piece.from)) return false;
  memory.move_on(monitor, piece);
  for (const std::size_t i : memory.list_near(pairs, limit)) {
    if (memory.is_beyond(i, pairs[i], limit) || memory.is_parted(monitor, i, pairs[i], limit)) continue;
    if (!pairs[i].convex || !(memory.calc_value(monitor, i, pairs[i], 1) >= limit)) return false;
    if (!memory.is_parted(monitor, i, pairs[i], limit)) return false;
  }
  return true;
}

std::optional<double> ShapeDips::calc_end(const ClearanceMonitor& monitor, const MotionPiece& piece) {
  Memory& memory = *memory_;
  const std::vector<ShapePair>& pairs = monitor.get_shape_pairs(memory.get_pair());
  if (skipping_ == Skipping::kOff || !memory.is_convex() || !(piece.to > piece.from)) return {};
  memory.move_on(monitor, piece);
  std::size_t nearest = memory.get_nearest();
  double least = memory.calc_value(monitor, nearest, pairs[nearest], 1);
  for (const std::size_t i : memory.list_near(pairs, least)) {
    if (i == nearest || memory.is_apart_at_end(monitor, i, pairs[i], least)) continue;
    const double value = memory.calc_value(monitor, i, pairs[i], 1);
    if (value < least) least = value, nearest = i;
  }
  memory.set_nearest(nearest);
  return least;
}

std::optional<double> ShapeDips::calc_within(const ClearanceMonitor& monitor, const MotionWindow& window, double time) {
  Memory& memory = *memory_;
  const std::vector<ShapePair>& pairs = monitor.get_shape_pairs(memory.get_pair());
  if (skipping_ == Skipping::kOff || !memory.is_convex() || pairs.size() < 2) return {};
  const MotionPiece &piece = window.get_present(), &before = window.get_previous();
  const bool is_present = time >= piece.from;
  if (!memory.is_of(piece) || time > piece.to || (!is_present && time < before.from)) return {};
  const MotionPiece& own = is_present ? piece : before;
  const geometry::Placement a = to_placement(own.calc_body(memory.get_a(), time)),
                            b = to_placement(own.calc_body(memory.get_b(), time));
  const std::size_t nearest = memory.get_nearest();
  double least = monitor.calc_pair(pairs[nearest], a, b).distance;
  const std::vector<std::size_t>* const near =
      is_present ? &memory.list_near(pairs, least) : memory.find_near_before(before, least);
  if (near == nullptr) return {};
  const geometry::Placement seen = memory.see_moving(a, b);
  for (const std::size_t i : *near) {
    if (i == nearest || (is_present && memory.is_beyond(i, pairs[i], least)) ||
        memory.is_parted_at(monitor, i, pairs[i], seen, least))
      continue;
    least = std::min(least, monitor.calc_pair(pairs[i], a, b).distance);
  }
  return least;
}

std::optional<Dip> ShapeDips::find(const ClearanceMonitor& monitor, const MotionPiece& piece, const DipSearch& search) {
  Memory& memory = *memory_;
  const std::vector<ShapePair>& pairs = monitor.get_shape_pairs(memory.get_pair());
  if (pairs.empty() || !(piece.to > piece.from)) return {};
  memory.move_on(monitor, piece);
  if (pairs.size() == 1 && search.at_from) memory.take_value(0, 0, *search.at_from);
  if (pairs.size() == 1 && search.at_to) memory.take_value(0, 1, *search.at_to);
  const auto place = [&](std::size_t body, double time) { return to_placement(piece.calc_body(body, time)); };
  // What is shallower is left to the knots: faces that lie along each other are nearest all over.
  constexpr double kShallow = 1e-8;  // of the pair's size
  const double threshold = search.limit - std::max(search.resolution, kShallow * monitor.get_size(memory.get_pair()));
  Least least;
  for (const std::size_t i : memory.list_near(pairs, skipping_ == Skipping::kOn ? threshold : kEver)) {
    const ShapePair& shapes = pairs[i];
    const double limit = std::min(threshold, least.get_value());
    const auto is_skipped = [&] {
      return skipping_ == Skipping::kOn &&
             (memory.is_beyond(i, shapes, limit) || memory.is_parted(monitor, i, shapes, limit));
    };
    if (is_skipped()) continue;
    const double at_from = memory.calc_value(monitor, i, shapes, 0);
    if (is_skipped()) continue;
    const double at_to = memory.calc_value(monitor, i, shapes, 1);
    if (is_skipped()) continue;
    // Within the piece the distance is at least the mean of both ends less half of the way.
    const double way = 0.5 * (search.length - std::abs(at_from - at_to));
    if (std::min(at_from, at_to) - way >= limit) continue;
    const auto function = [&](double time) {
      return monitor.calc_pair(shapes, place(memory.get_a(), time), place(memory.get_b(), time)).distance;
    };
    if (shapes.convex && skipping_ == Skipping::kOn &&
        !memory.may_dip(monitor, i, shapes, at_from, at_to, search.resolution))
      continue;
    if (shapes.convex)
      least.look_into(piece.from, at_from, piece.to, at_to, search.resolution, function);
    else
      sample(piece.from, at_from, piece.to, at_to, count_samples(way, shapes.size), search.resolution, function, least);
  }
  if (!(least.get_value() < threshold)) return {};
  return Dip{least.get_time(), least.get_value()};
}

}  // namespace unlatch::hil
