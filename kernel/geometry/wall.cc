// Distance of a thin wall and a convex core. The wall is the side of a frustum S, or half of it, its ends open.
//
//   distance = max(out, in)
//   out = signed distance of B and the solid S
//   in  = min over azimuths θ of the signed distance of B and the tangent strip P_θ
//
// P_θ is the part of the tangent plane beside the generator at θ; for a half wall it ends where its first corner
// reaches the plane of the edges.
//
// For a B apart from the wall this is their distance. Neither value exceeds it, since S and the strips together contain
// the wall, and one of them equals it. With B outside of S, the nearest point of S is on the wall, and `out` is exact;
// or it is on an open end, the nearest point of the wall is on a rim, and `in` is exact. With B inside of S, the
// nearest point of a nearest strip is on its generator, since a turn moves all others, and `in` is exact. For an
// overlap it is minus the lesser of two continuous depths: B's greatest height over the wall, and the way out of S.
//
// `in` has a local minimum for each part of B that protrudes towards the wall. The least of them is found by branch and
// bound over arcs of azimuths (Land and Doig 1960): a lower bound of an arc is exact to second order of its width
// (`Strips`), and an arc that may contain less than the least strip so far is halved.
#include <limits>

#include "kernel/geometry/distance.h"
#include "kernel/geometry/penetration.h"
#include "kernel/geometry/strips.h"
#include "unlatch/elementary.h"

namespace unlatch::geometry {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kFirstArcs = 8;               // of the full circle
constexpr double kFirstWidth = 0.25 * kPi;  // rad
constexpr int kMostHalvings = 15;           // to 2.4e-5 rad, where a bound is exact to 1e-10 of B's radius of curvature
constexpr int kMostArcs = 384;              // that are examined
constexpr int kMostStrips = 48;             // whose directions bound the arcs
constexpr int kMostSteps = 40;              // of a descent
constexpr double kStationary = 1e-9;        // of the pair's size, per rad: no descent from there
constexpr double kTurn = 1e-9;              // rad, an interval whose distance does not change
constexpr double kLess = 1e-11;             // of the pair's size: a smaller gain ends the search

// Minimum between two strips, by the signs of their rates: the root of the rate (Illinois, Dowell and Jarratt 1971),
// else the least strip that was computed.
void descend_between(const Strips& strips, Strip left, Strip right, Strip& best) {
  double weight_left = left.rate, weight_right = right.rate;
  int side = 0;
  for (int i = 0; i < kMostSteps && right.azimuth - left.azimuth > kTurn; ++i) {
    // Every third step halves, so that the interval shrinks whatever the rate does.
    const double share = i % 3 == 2 ? 0.5 : weight_left / (weight_left - weight_right);
    const Strip middle = strips.calc_strip(left.azimuth + (right.azimuth - left.azimuth) * share);
    if (middle.d.distance < best.d.distance) best = middle;
    if (std::fabs(middle.rate) <= kStationary * strips.get_size()) return;
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

// The strip at the local minimum to which the distance falls from `at`.
Strip descend(const Strips& strips, Strip at) {
  constexpr double kLeastStep = 1e-7, kMostStep = 0.3;  // rad
  Strip best = at;
  // First to the azimuth of B's nearest point, where a corner or a sphere has its minimum; then by the secant.
  double step = std::fabs(strips.calc_azimuth(at.d.on_b) - at.azimuth);
  for (int i = 0; i < kMostSteps && std::fabs(at.rate) > kStationary * strips.get_size(); ++i) {
    step = step < kLeastStep ? kLeastStep : (step > kMostStep ? kMostStep : step);
    const double to = strips.clamp(at.rate < 0 ? at.azimuth + step : at.azimuth - step);
    if (to == at.azimuth) break;  // an edge of a half
    const Strip next = strips.calc_strip(to);
    if (next.d.distance < best.d.distance) best = next;
    if (next.rate < 0 && at.rate > 0) {
      descend_between(strips, next, at, best);
      break;
    }
    if (next.rate > 0 && at.rate < 0) {
      descend_between(strips, at, next, best);
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
    Reach at_from, at_to;
    double bound;  // m
    int direction, halvings;
  };
  const Strips strips(solid, b);
  const double worth = kLess * strips.get_size();
  TurningDirection directions[kMostStrips];
  Arc arcs[kMostArcs];
  int known = 0, count = 0;

  // Halves of the arcs that are halved so often, as far as they are known.
  HalfArc halves[kMostHalvings + 1];
  int halves_known = 0;
  const auto get_half = [&](int halvings) -> const HalfArc& {
    for (; halves_known <= halvings; ++halves_known) {
      HalfArc& half = halves[halves_known];
      elementary::sincos(0.5 * kFirstWidth / (1 << halves_known), half.sine, half.cosine);
    }
    return halves[halvings];
  };

  Strip best = descend(strips, strips.calc_strip(strips.clamp(strips.calc_azimuth(b.c))));
  directions[known++] = strips.calc_direction(best, strips.calc_axes(best.azimuth));
  const auto is_worth = [&](double bound) { return bound < best.d.distance - worth; };
  const auto add = [&](double from, double to, const Reach& at_from, const Reach& at_to, int direction, int halvings) {
    const double bound = strips.calc_bound(directions[direction], from, to, get_half(halvings), at_from, at_to);
    if (is_worth(bound) && count < kMostArcs) arcs[count++] = {from, to, at_from, at_to, bound, direction, halvings};
  };

  const int first_arcs = strips.is_half() ? kFirstArcs / 2 : kFirstArcs;
  double from = strips.is_half() ? -0.5 * kPi : -kPi;
  Reach at_from = strips.calc_reach(directions[0], strips.calc_axes(from));
  for (int i = 0; i < first_arcs; ++i) {
    const double to = from + kFirstWidth;
    const Reach at_to = strips.calc_reach(directions[0], strips.calc_axes(to));
    add(from, to, at_from, at_to, 0, 0);
    from = to, at_from = at_to;
  }
  for (int i = 0; i < count; ++i) {
    Arc arc = arcs[i];
    if (!is_worth(arc.bound) || arc.halvings == kMostHalvings) continue;
    const double middle = 0.5 * (arc.from + arc.to);
    const Strips::Axes axes = strips.calc_axes(middle);
    Reach at_middle = strips.calc_reach(directions[arc.direction], axes);
    // Where the bound at the middle does not decide, the strip there is computed.
    if (is_worth(strips.calc_bound(directions[arc.direction], middle, at_middle)) && known < kMostStrips) {
      const Strip strip = strips.calc_strip(axes);
      if (strip.d.distance < best.d.distance) best = descend(strips, strip);
      arc.direction = known++;
      const TurningDirection& u = directions[arc.direction] = strips.calc_direction(strip, axes);
      arc.at_from = strips.calc_reach(u, strips.calc_axes(arc.from));
      arc.at_to = strips.calc_reach(u, strips.calc_axes(arc.to));
      at_middle = strips.calc_reach(u, axes);
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
