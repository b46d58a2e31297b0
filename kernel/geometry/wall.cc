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
//
// `in` has as many local minima as B has points that reach towards the wall, near each other or not. The least of them
// is found by branch and bound over arcs of azimuths (Land and Doig 1960): a lower bound of an arc is exact to the
// second order of its width (`Widths`), and an arc that may hold less than the least strip so far is halved.
#include <limits>

#include "kernel/geometry/distance.h"
#include "kernel/geometry/penetration.h"
#include "unlatch/elementary.h"

namespace unlatch::geometry {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFirstArcs = 8;               // of the full circle
constexpr double kFirstWidth = 0.25 * kPi;  // rad
constexpr int kMostHalvings = 15;           // to 2.4e-5 rad, where a bound is exact to 1e-10 of B's radius of curvature
constexpr int kMostArcs = 384;              // that are looked at
constexpr int kMostStrips = 48;             // that arcs are judged by
constexpr int kMostSteps = 40;              // of a descent
constexpr double kStationary = 1e-9;        // of the pair's size, per rad: no descent from there
constexpr double kTurn = 1e-9;              // rad, an interval whose distance does not change
constexpr double kLess = 1e-11;             // of the pair's size: a distance that is less by this is worth the search

struct Strip {
  Distance d;
  double azimuth = 0;  // rad
  double rate = 0;     // m/rad, of the distance by the azimuth
};

// Axes of the strip at an azimuth: radial, and along the wall's rims.
struct Axes {
  Vec3 e, t;
  double cosine, sine;
};

// Extent of a strip across its generator, m.
struct Extent {
  double low, high;
};

// The wall beside B: its strips, and lower bounds of their distances.
class Wall {
 public:
  Wall(const Core& solid, const Core& b)
      : solid_(solid),
        b_(b),
        size_(calc_pair_size(solid, b)),
        is_half_(solid.kind == Core::Kind::kHalfFrustum),
        has_rims_(b.kind == Core::Kind::kFrustum) {}

  double get_size() const { return size_; }
  bool is_half() const { return is_half_; }
  double clamp(double azimuth) const {
    if (!is_half_) return azimuth;
    return azimuth < -0.5 * kPi ? -0.5 * kPi : (azimuth > 0.5 * kPi ? 0.5 * kPi : azimuth);
  }
  double calc_azimuth(const Vec3& point) const {
    const Vec3 way = point - solid_.c;
    return elementary::atan2(dot(way, solid_.R.y), dot(way, solid_.R.x));
  }

  Strip calc_strip(double azimuth) const {
    const Axes at = calc_axes(azimuth);
    Core strip;
    strip.kind = Core::Kind::kBox;
    strip.R.z = solid_.gr * at.e + solid_.gz * solid_.R.z;
    strip.R.y = at.t;
    strip.R.x = solid_.gz * at.e - solid_.gr * solid_.R.z;  // outwards: (y × z)
    const Extent wide = calc_extent(at);
    strip.c = solid_.c + (0.5 * (solid_.r0 + solid_.r1)) * at.e + (0.5 * (wide.low + wide.high)) * at.t;
    strip.half = {0, 0.5 * (wide.high - wide.low), 0.5 * solid_.length};
    strip.bound = norm(strip.half);
    Strip out;
    const Closest closest = calc_closest(strip, b_);
    if (closest.apart) {
      out.d = {closest.distance, closest.a, closest.b, closest.n, closest.gap};
    } else {
      const Depth depth = calc_depth(strip, b_);
      out.d = {-depth.depth, depth.a, depth.b, depth.n, depth.gap};
    }
    out.azimuth = azimuth;
    out.rate = -dot(out.d.normal, cross(solid_.R.z, out.d.on_a - solid_.c));
    return out;
  }

  // A direction that turns with the azimuth θ: the slab between a strip and B across it is a lower bound of their
  // distance, also of an overlap.
  //
  // The reach H(θ) of B against it has H + H'' ≥ −residue, so that H + residue is below the sinusoid through the ends
  // of an arc. For a point at the height z over the solid's centre, H + H'' = −u.z z. B is taken as one part, the
  // residue the greatest of its points, or a frustum as its two rims: a rim of radius r has r (g + g'') more
  // (`calc_roundness`).
  struct Direction {
    double e, t, z;     // unit length, from the strip to B
    double of_wall;     // m, the strip's extent along e and z
    double residue[2];  // m, of each part
  };
  struct Reach {
    double of[2];  // m, of each part, with its residue
  };

  // The direction of a strip's own normal: there the bound is the distance. Of a whole wall without t, in which its
  // strips have no end.
  Direction calc_direction(const Strip& strip) const {
    const Axes at = calc_axes(strip.azimuth);
    Direction u;
    u.e = dot(strip.d.normal, at.e), u.t = is_half_ ? dot(strip.d.normal, at.t) : 0.0;
    u.z = dot(strip.d.normal, solid_.R.z);
    const double length = std::sqrt((u.e * u.e + u.t * u.t) + u.z * u.z);
    constexpr double kLeast = 0.1;
    if (length > kLeast) {
      u.e *= 1 / length, u.t *= 1 / length, u.z *= 1 / length;
    } else {
      u.e = -1, u.t = 0, u.z = 0;
    }
    u.of_wall =
        0.5 * (solid_.r0 + solid_.r1) * u.e + 0.5 * solid_.length * std::fabs(solid_.gr * u.e + solid_.gz * u.z);
    if (has_rims_) {
      const double roundness = calc_roundness(u);
      const double centre = dot(b_.c - solid_.c, solid_.R.z), half = b_.h * dot(b_.R.z, solid_.R.z);
      u.residue[0] = u.z * (centre - half) - b_.r0 * roundness;
      u.residue[1] = u.z * (centre + half) - b_.r1 * roundness;
    } else {
      u.residue[0] = u.residue[1] = calc_extent_of_b(u.z * solid_.R.z);
    }
    return u;
  }

  Reach calc_reach(const Direction& u, double azimuth) const {
    const Axes at = calc_axes(azimuth);
    const Vec3 d = -((u.e * at.e + u.t * at.t) + u.z * solid_.R.z);
    if (!has_rims_) {
      const double reach = calc_extent_of_b(d) + u.residue[0];
      return {{reach, reach}};
    }
    const double x = dot(d, b_.R.z), square = 1 - x * x, across = square > 0 ? std::sqrt(square) : 0.0;
    const double centre = dot(d, b_.c - solid_.c);
    return {
        {((centre - b_.h * x) + b_.r0 * across) + u.residue[0], ((centre + b_.h * x) + b_.r1 * across) + u.residue[1]}};
  }

  // Lower bound of the distance of the strip at an azimuth.
  double calc_bound(const Direction& u, double azimuth, const Reach& at) const {
    return calc_bound(u, azimuth, azimuth, at.of[0], at.of[1]);
  }
  // The same of all strips of an arc, by the reaches at both ends: between them each part's is below the sinusoid
  // through both.
  double calc_bound(const Direction& u, double from, double to, const Reach& at_from, const Reach& at_to) const {
    double s, c;
    elementary::sincos(0.5 * (to - from), s, c);
    const double cosine = 1 - 2 * s * s;  // of the arc
    const auto calc_most = [&](double x, double y) {
      if (!(y > x * cosine && x > y * cosine)) return x > y ? x : y;
      const double half = (y - x) / (2 * s);
      return std::sqrt(half * half + x * y) / c;
    };
    return calc_bound(u, from, to, calc_most(at_from.of[0], at_to.of[0]), calc_most(at_from.of[1], at_to.of[1]));
  }

 private:
  Axes calc_axes(double azimuth) const {
    double s, c;
    elementary::sincos(azimuth, s, c);
    return {c * solid_.R.x + s * solid_.R.y, c * solid_.R.y - s * solid_.R.x, c, s};
  }
  double calc_extent_of_b(const Vec3& d) const { return dot(d, calc_support(b_, d) - solid_.c); }
  // A lower bound of g + g'' over all azimuths, 0 at least: g = √(1 − x²) is the reach of a rim of radius 1, x = q + p
  // cos(θ − θ0) the cosine between the direction and B's axis. g + g'' = (1 + q² − p² − 3 q x + q x³) / g³, and 3 x −
  // x³ grows.
  double calc_roundness(const Direction& u) const {
    const double tilt = dot(b_.R.z, solid_.R.z), sine = norm(cross(b_.R.z, solid_.R.z));
    const double p = std::sqrt(u.e * u.e + u.t * u.t) * sine, q = std::fabs(u.z * tilt);
    const double most = p + q < 1 ? p + q : 1.0, least = q > p ? q - p : 0.0;
    const double left = ((1 - p * p) + q * q) - q * most * (3 - most * most), square = 1 - least * least;
    return left > 0 && square > 0 ? left / (square * std::sqrt(square)) : 0.0;
  }
  double calc_bound(const Direction& u, double from, double to, double most_0, double most_1) const {
    const double reach_0 = most_0 - u.residue[0], reach_1 = most_1 - u.residue[1];
    const double bound = -(reach_0 > reach_1 ? reach_0 : reach_1) - u.of_wall;
    if (u.t > 0) return bound - u.t * calc_extent(calc_axes(from)).high;
    if (u.t < 0) return bound - u.t * calc_extent(calc_axes(to)).low;
    return bound;
  }
  // Narrower the nearer the generator is to an edge: neither end passes the plane of the edges.
  Extent calc_extent(const Axes& at) const {
    Extent out{-2 * size_, 2 * size_};
    if (!is_half_) return out;
    const double r = solid_.r0 < solid_.r1 ? solid_.r0 : solid_.r1, reach = at.cosine > 0 ? r * at.cosine : 0.0;
    if (at.sine > 0 && reach < out.high * at.sine) out.high = reach / at.sine;
    if (at.sine < 0 && reach < out.low * at.sine) out.low = reach / at.sine;
    return out;
  }

  const Core &solid_, &b_;
  const double size_;
  const bool is_half_, has_rims_;
};

// Between two strips whose rates say that a minimum is between them: the root of the rate (Illinois, Dowell and Jarratt
// 1971), else the least that was seen.
void descend_between(const Wall& wall, Strip left, Strip right, Strip& best) {
  double weight_left = left.rate, weight_right = right.rate;
  int side = 0;
  for (int i = 0; i < kMostSteps && right.azimuth - left.azimuth > kTurn; ++i) {
    // Every third step halves, so that the interval shrinks whatever the rate does.
    const double share = i % 3 == 2 ? 0.5 : weight_left / (weight_left - weight_right);
    const Strip middle = wall.calc_strip(left.azimuth + (right.azimuth - left.azimuth) * share);
    if (middle.d.distance < best.d.distance) best = middle;
    if (std::fabs(middle.rate) <= kStationary * wall.get_size()) return;
    if (middle.rate < 0) {
      left = middle, weight_left = middle.rate;
      if (side == -1) weight_right *= 0.5;
      side = -1;
    } else {
      right = middle, weight_right = middle.rate;
      if (side == 1) weight_left *= 0.5;
      side = 1;
    }
  }
}

// Least strip of the valley in which `at` is.
Strip descend(const Wall& wall, Strip at) {
  constexpr double kLeastStep = 1e-7, kMostStep = 0.3;  // rad
  Strip best = at;
  // First to the azimuth of B's nearest point, where a corner or a sphere has its minimum; then by the secant.
  double step = std::fabs(wall.calc_azimuth(at.d.on_b) - at.azimuth);
  for (int i = 0; i < kMostSteps && std::fabs(at.rate) > kStationary * wall.get_size(); ++i) {
    step = step < kLeastStep ? kLeastStep : (step > kMostStep ? kMostStep : step);
    const double to = wall.clamp(at.rate < 0 ? at.azimuth + step : at.azimuth - step);
    if (to == at.azimuth) break;  // an edge of a half
    const Strip next = wall.calc_strip(to);
    if (next.d.distance < best.d.distance) best = next;
    if (next.rate < 0 && at.rate > 0) {
      descend_between(wall, next, at, best);
      break;
    }
    if (next.rate > 0 && at.rate < 0) {
      descend_between(wall, at, next, best);
      break;
    }
    const double change = std::fabs(at.rate) - std::fabs(next.rate);
    step = change > 0.25 * std::fabs(next.rate) ? step * std::fabs(next.rate) / change : 4 * step;
    at = next;
  }
  return best;
}

Distance calc_in(const Core& solid, const Core& b) {
  struct Arc {
    double from, to;  // rad
    Wall::Reach at_from, at_to;
    double bound;  // m
    int direction, halvings;
  };
  const Wall wall(solid, b);
  const double worth = kLess * wall.get_size();
  Wall::Direction directions[kMostStrips];
  Arc arcs[kMostArcs];
  int strips = 0, count = 0;

  Strip best = descend(wall, wall.calc_strip(wall.clamp(wall.calc_azimuth(b.c))));
  directions[strips++] = wall.calc_direction(best);
  const auto is_worth = [&](double bound) { return bound < best.d.distance - worth; };
  const auto add = [&](double from, double to, const Wall::Reach& at_from, const Wall::Reach& at_to, int direction,
                       int halvings) {
    const double bound = wall.calc_bound(directions[direction], from, to, at_from, at_to);
    if (is_worth(bound) && count < kMostArcs) arcs[count++] = {from, to, at_from, at_to, bound, direction, halvings};
  };

  const int first_arcs = wall.is_half() ? kFirstArcs / 2 : kFirstArcs;
  double from = wall.is_half() ? -0.5 * kPi : -kPi;
  Wall::Reach at_from = wall.calc_reach(directions[0], from);
  for (int i = 0; i < first_arcs; ++i) {
    const double to = from + kFirstWidth;
    const Wall::Reach at_to = wall.calc_reach(directions[0], to);
    add(from, to, at_from, at_to, 0, 0);
    from = to, at_from = at_to;
  }
  for (int i = 0; i < count; ++i) {
    Arc arc = arcs[i];
    if (!is_worth(arc.bound) || arc.halvings == kMostHalvings) continue;
    const double middle = 0.5 * (arc.from + arc.to);
    Wall::Reach at_middle = wall.calc_reach(directions[arc.direction], middle);
    // The strip itself settles what a bound of it alone leaves open.
    if (is_worth(wall.calc_bound(directions[arc.direction], middle, at_middle)) && strips < kMostStrips) {
      const Strip strip = wall.calc_strip(middle);
      if (strip.d.distance < best.d.distance) best = descend(wall, strip);
      arc.direction = strips++;
      const Wall::Direction& u = directions[arc.direction] = wall.calc_direction(strip);
      arc.at_from = wall.calc_reach(u, arc.from), arc.at_to = wall.calc_reach(u, arc.to);
      at_middle = wall.calc_reach(u, middle);
    }
    add(arc.from, middle, arc.at_from, at_middle, arc.direction, arc.halvings + 1);
    add(middle, arc.to, at_middle, arc.at_to, arc.direction, arc.halvings + 1);
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
