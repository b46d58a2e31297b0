// Distance of a thin wall and a convex core. The wall is the side of a frustum S, or half of it, its ends open.
//
//   distance = max(out, in)
//   out = signed distance of B and the solid S
//   in  = min over azimuths θ of the signed distance of B and the tangent strip P_θ: the generator at θ, widened across
//   it
//         in the tangent plane (of a half wall: not beyond the plane of its edges)
//
// Apart, this is the distance to the wall: neither is more than it, because S and the strips contain the wall; where B
// is beside or before S, the nearest point of S is on the wall and `out` is exact, or on an open end and the nearest
// point of the wall is on its rim, where `in` is; where B is in S, a nearest strip has its nearest point on its
// generator, for turning a strip moves all its other points, and `in` is exact. Overlapping, it is minus the lesser of
// two depths: the greatest height by which B stands out of the wall, and the way out of the solid. Both are continuous.
#include <limits>

#include "kernel/geometry/distance.h"
#include "kernel/geometry/penetration.h"
#include "unlatch/elementary.h"

namespace unlatch::geometry {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFullSamples = 48;  // around the wall; every second but for hulls, whose corners are narrow
constexpr int kHalfSamples = 25;  // the same of a half, edges included
constexpr int kMostRefinements = 40;
constexpr double kStationary = 1e-9;  // of the pair's size, per rad: what is left of an interval is less than it
constexpr double kTurn = 1e-9;        // rad; the distance is stationary there, so that its error is of second order

struct Strip {
  Distance d;
  double rate = 0;  // m/rad, of the distance by the azimuth
};

Strip calc_strip(const Core& solid, const Core& b, double azimuth, double size) {
  double s, c;
  elementary::sincos(azimuth, s, c);
  const Vec3 e = c * solid.R.x + s * solid.R.y, t = c * solid.R.y - s * solid.R.x;
  Core strip;
  strip.kind = Core::Kind::kBox;
  strip.R.z = solid.gr * e + solid.gz * solid.R.z;
  strip.R.y = t;
  strip.R.x = solid.gz * e - solid.gr * solid.R.z;  // outwards: (y × z)
  strip.c = solid.c + (0.5 * (solid.r0 + solid.r1)) * e;
  double low = -2 * size, high = 2 * size;
  if (solid.kind == Core::Kind::kHalfFrustum) {
    const double r = solid.r0 < solid.r1 ? solid.r0 : solid.r1, reach = c > 0 ? r * c : 0.0;
    if (s > 0 && reach < high * s) high = reach / s;
    if (s < 0 && reach < low * s) low = reach / s;
  }
  strip.c += (0.5 * (low + high)) * t;
  strip.half = {0, 0.5 * (high - low), 0.5 * solid.length};
  strip.bound = norm(strip.half);
  Strip out;
  const Closest closest = calc_closest(strip, b);
  if (closest.apart) {
    out.d = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
  } else {
    const Depth depth = calc_depth(strip, b);
    out.d = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
  }
  out.rate = -dot(out.d.normal, cross(solid.R.z, out.d.on_a - solid.c));
  return out;
}

// Between two samples: the root of the rate (Illinois, Dowell and Jarratt 1971), else the best that was seen.
void refine(const Core& solid, const Core& b, double size, double from, Strip left, double to, Strip right,
            Strip& best) {
  double weight_left = left.rate, weight_right = right.rate;
  if (!(weight_left < 0 && weight_right > 0)) return;
  int side = 0;
  for (int i = 0; i < kMostRefinements && to - from > kTurn; ++i) {
    // Every third step halves, so that the interval shrinks whatever the rate does.
    const double at =
        i % 3 == 2 ? 0.5 * (from + to) : from + (to - from) * (weight_left / (weight_left - weight_right));
    const Strip middle = calc_strip(solid, b, at, size);
    if (middle.d.distance < best.d.distance) best = middle;
    if (std::fabs(middle.rate) <= kStationary * size) return;
    if (middle.rate < 0) {
      from = at, weight_left = middle.rate;
      if (side == -1) weight_right *= 0.5;
      side = -1;
    } else {
      to = at, weight_right = middle.rate;
      if (side == 1) weight_left *= 0.5;
      side = 1;
    }
  }
}

// Azimuths at equal steps, all round or over a half.
struct Fan {
  double first, step;
  int count;  // of samples
  int arcs;   // between them
  double get_azimuth(int i) const { return first + step * i; }
};

Fan build_fan(const Core& solid, const Core& b) {
  const int thin = b.kind == Core::Kind::kPoints ? 1 : 2;
  if (solid.kind != Core::Kind::kHalfFrustum) {
    const int count = kFullSamples / thin;
    return {0, 2 * kPi / count, count, count};
  }
  const int count = (kHalfSamples - 1) / thin + 1;
  return {-0.5 * kPi, kPi / (count - 1), count, count - 1};
}

// Lower bounds of the distance from B to the strips of an arc: the width of the slab between B and the strip along a
// direction that turns with the azimuth, u = −cos φ n ± sin φ z with the strip's normal n outwards; φ leads to a B
// beyond an open end. Of a B that is not about the axis also along n. Between two azimuths the directions are α u1 + β
// u2 but for a part (1 − α − β) of what does not turn, 1 ≤ α + β ≤ κ = 1/cos(step/2), and supports are sublinear.
class ArcBounds {
 public:
  ArcBounds(const Core& solid, const Core& b, const Fan& fan)
      : solid_(solid), b_(b), fan_(fan), plane_(solid.gz * (0.5 * (solid.r0 + solid.r1))) {
    const Vec3 way = b.c - solid.c;
    along_ = dot(way, solid.R.z);
    foot_ = solid.c + along_ * solid.R.z;
    const double off = norm(b.c - foot_);
    around_ = off < plane_;
    excess_ = calc_excess(1), close_excess_ = calc_excess(kParts);
    turn_to_open_end();
    const double fixed = std::fabs(cosine_ * solid.gr + sine_), slant = std::fabs(solid.gr);
    rest_ = (fixed > slant ? fixed : slant) * (off + b.bound);
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    for (int i = 0; i <= fan.arcs; ++i) {
      ends_[i] = measure(i);
      least = ends_[i].out < least ? ends_[i].out : least;
      greatest = ends_[i].out > greatest ? ends_[i].out : greatest;
    }
    is_even_ = around_ && greatest - least < (close_excess_ - 1) * (std::fabs(greatest) + rest_);
  }

  // Of an arc; and nearer to the truth by parts of it, unless B is so even about the axis that this would not tell arcs
  // from one another.
  double calc(int arc) const { return calc(ends_[arc], ends_[arc + 1], excess_); }
  double calc_closer(int arc) const {
    if (is_even_) return calc(arc);
    double least = std::numeric_limits<double>::infinity();
    Extent last = ends_[arc];
    for (int k = 1; k <= kParts; ++k) {
      const Extent next = k < kParts ? measure(arc + k * (1.0 / kParts)) : ends_[arc + 1];
      const double bound = calc(last, next, close_excess_);
      least = bound < least ? bound : least;
      last = next;
    }
    return least;
  }

 private:
  static constexpr int kParts = 8;
  // Reach of B along −u and −n, from the foot.
  struct Extent {
    double out, in;
  };

  double calc_excess(int parts) const {  // κ
    double s, c;
    elementary::sincos(0.5 * fan_.step / parts, s, c);
    return 1 / c;
  }
  Vec3 calc_normal(double sample) const {
    double s, c;
    elementary::sincos(fan_.first + fan_.step * sample, s, c);
    return solid_.gz * (c * solid_.R.x + s * solid_.R.y) - solid_.gr * solid_.R.z;
  }
  double calc_extent_of_b(const Vec3& d) const { return dot(d, calc_support(b_, d) - foot_); }

  // φ by the gaps along the axis and, of the first sample and the one across it, along the normal.
  void turn_to_open_end() {
    const double above = (along_ - calc_extent_of_b(-solid_.R.z)) - solid_.h;
    const double below = (-along_ - calc_extent_of_b(solid_.R.z)) - solid_.h;
    const double beyond = above > below ? above : below;
    if (!(around_ && beyond > 0)) return;
    const double gap = (plane_ + along_ * solid_.gr) -
                       0.5 * (calc_extent_of_b(calc_normal(0)) + calc_extent_of_b(calc_normal(0.5 * fan_.arcs)));
    const double width = gap > 0 ? gap : 0.0, axial = above > below ? beyond : -beyond;
    const double length = std::sqrt((width * width + beyond * beyond) + 2 * width * axial * solid_.gr);  // n · z = −gr
    if (!(length > 0)) return;
    cosine_ = width / length;
    sine_ = axial / length;
  }
  Extent measure(double sample) const {
    const Vec3 n = calc_normal(sample);
    return {calc_extent_of_b(cosine_ * n - sine_ * solid_.R.z), around_ ? 0.0 : calc_extent_of_b(-n)};
  }
  double calc(const Extent& a, const Extent& b, double excess) const {
    const auto raise = [&](double x, double y) {
      const double greater = x > y ? x : y;
      return (greater > 0 ? excess * greater : greater) + (excess - 1) * rest_;
    };
    const double wall = (cosine_ * plane_ - std::fabs(sine_) * solid_.h) + along_ * (cosine_ * solid_.gr + sine_);
    const double along = wall - raise(a.out, b.out);
    if (around_) return along;
    const double inwards = (-plane_ - along_ * solid_.gr) - raise(a.in, b.in);
    return along > inwards ? along : inwards;
  }

  const Core &solid_, &b_;
  const Fan& fan_;
  Vec3 foot_{0, 0, 0};  // of B's centre on the axis
  double plane_, along_ = 0, rest_ = 0;
  double cosine_ = 1, sine_ = 0;  // of −n and z in u
  double excess_, close_excess_;
  bool around_ = false, is_even_ = false;
  Extent ends_[kFullSamples + 1];
};

// Arcs that cannot hold less than `least` are left out, which cannot change a bit of the result. A computed distance is
// below the true one by rounding where B is apart, by the depth's error (README) where it overlaps.
bool may_hold(double bound, double least, double size) { return bound - (bound > 0 ? 1e-11 : 1e-4) * size <= least; }

Distance calc_in(const Core& solid, const Core& b) {
  const Fan fan = build_fan(solid, b);
  const double size = calc_pair_size(solid, b);
  const ArcBounds bounds(solid, b, fan);
  Strip samples[kFullSamples];
  bool known[kFullSamples] = {}, matters[kFullSamples] = {};
  double least = std::numeric_limits<double>::infinity();
  const auto sample = [&](int i) {
    if (known[i]) return;
    known[i] = true;
    samples[i] = calc_strip(solid, b, fan.get_azimuth(i), size);
    if (samples[i].d.distance < least) least = samples[i].d.distance;
  };
  int nearest = 0;
  for (int i = 1; i < fan.arcs; ++i)
    if (bounds.calc(i) < bounds.calc(nearest)) nearest = i;
  sample(nearest);
  for (int i = 0; i < fan.arcs; ++i) {
    matters[i] = may_hold(bounds.calc(i), least, size) && may_hold(bounds.calc_closer(i), least, size);
    if (!matters[i]) continue;
    sample(i);
    sample((i + 1) % fan.count);
  }
  Strip best;
  for (int i = 0; i < fan.count; ++i)
    if (known[i] && samples[i].d.distance < best.d.distance) best = samples[i];
  const double coarse = best.d.distance;
  for (int i = 0; i < fan.arcs; ++i) {
    if (!matters[i]) continue;
    const Strip &left = samples[i], &right = samples[(i + 1) % fan.count];
    // Turning by half a step changes the distance by at most this.
    const double lesser = left.d.distance < right.d.distance ? left.d.distance : right.d.distance;
    const double reach = 0.25 * fan.step * (std::fabs(left.rate) + std::fabs(right.rate)) + 1e-12 * size;
    if (lesser - reach <= coarse) refine(solid, b, size, fan.get_azimuth(i), left, fan.get_azimuth(i + 1), right, best);
  }
  return best.d;
}

}  // namespace

Distance calc_wall(const Core& solid, const Rounded& b) {
  Distance out;
  const Closest closest = calc_closest(solid, b.core);
  if (closest.apart) {
    out = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
    const Vec3 on_wall = transpose_times(solid.R, out.on_a - solid.c);
    const double rho = solid.kind == Core::Kind::kHalfFrustum && !(on_wall.x > 0)
                           ? std::fabs(on_wall.y)
                           : std::sqrt(on_wall.x * on_wall.x + on_wall.y * on_wall.y);
    const double away = std::fabs((rho - solid.r0) * solid.gz - (on_wall.z + solid.h) * solid.gr);
    if (away > 1e-13 * solid.bound) {  // on an open end
      const Distance in = calc_in(solid, b.core);
      if (in.distance > out.distance) out = in;
    }
  } else {
    out = calc_in(solid, b.core);
    if (!(out.distance > 0)) {
      const Depth depth = calc_depth(solid, b.core);
      if (-depth.depth > out.distance) out = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
    }
  }
  out.distance -= b.radius;
  out.on_b -= b.radius * out.normal;
  return out;
}

}  // namespace unlatch::geometry
