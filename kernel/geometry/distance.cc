// Pairs of shapes: their order, their cores, and which method computes them.
#include "kernel/geometry/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/geometry/middle.h"

namespace unlatch::geometry {
namespace {

struct Placed {
  Vec3 c;  // centre, from the pair's origin
  Mat3 R;  // axes in W
};

Placed place(const ShapeNumbers& shape, const Placement& at, const Vec3& origin) {
  const Vec3 c = (at.p_WB - origin) + at.R_WB * shape.p_BS;
  return {c, shape.kind == ShapeKind::kSphere ? at.R_WB : at.R_WB * shape.R_BS};  // the axes of a sphere do not matter
}

Rounded build_core(const ShapeView& view, const Placed& at) {
  const ShapeNumbers& shape = view.numbers;
  Rounded out;
  Core& core = out.core;
  core.c = at.c;
  core.R = at.R;
  core.bound = shape.bound;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      core.bound = 0;
      out.radius = shape.r0;
      break;
    case ShapeKind::kCapsule:
      core.kind = Core::Kind::kSegment;
      core.h = core.bound = shape.half_length;
      out.radius = shape.r0;
      break;
    case ShapeKind::kBox:
      core.kind = Core::Kind::kBox;
      core.half = shape.half_size;
      break;
    case ShapeKind::kHull:
      core.kind = Core::Kind::kPoints;
      core.points = view.points.data();
      core.count = static_cast<int>(view.points.size());
      break;
    default:
      core.kind = Core::Kind::kFrustum;
      core.h = shape.half_length;
      core.r0 = shape.r0;
      core.r1 = shape.r1;
      core.gr = shape.slope_r;
      core.gz = shape.slope_z;
      core.length = shape.generator;
      break;
  }
  return out;
}

Distance calc_half_space(const Placed& space, const Rounded& b) {
  Distance out;
  out.normal = space.R.z;
  // The plane is taken as a square, large beside B, so that the middle is that of B's face.
  Core square;
  square.kind = Core::Kind::kBox;
  square.R = space.R;
  const double over = dot(out.normal, b.core.c - space.c), wide = 2 * b.core.bound;
  square.c = b.core.c - over * out.normal;
  square.half = {wide, wide, 0};
  out.on_b = calc_support(b.core, -out.normal);
  const double height = dot(out.normal, out.on_b - space.c);
  out.on_a = out.on_b - height * out.normal;
  move_to_middle(square, b.core, out.normal, wide, out.on_a, out.on_b);
  out.on_b -= b.radius * out.normal;
  out.distance = height - b.radius;
  return out;
}

// The solid between two points of a profile.
Core build_piece(const ShapeView& hollow, const Placed& at, std::size_t i) {
  const ProfilePoint &p = hollow.profile[i], &q = hollow.profile[i + 1];
  Core solid;
  solid.kind = hollow.numbers.half ? Core::Kind::kHalfFrustum : Core::Kind::kFrustum;
  solid.R = at.R;
  solid.c = at.c + (0.5 * (p.z + q.z)) * at.R.z;
  solid.h = 0.5 * (q.z - p.z);
  solid.r0 = p.r;
  solid.r1 = q.r;
  const double r = p.r > q.r ? p.r : q.r;
  solid.bound = std::sqrt(solid.h * solid.h + r * r);
  update_generator(solid);
  return solid;
}

// The least distance of the walls between the profile's points.
Distance calc_hollow(const ShapeView& hollow, const Placed& at, const Rounded& b) {
  Distance least;
  for (std::size_t i = 0; i + 1 < hollow.profile.size(); ++i) {
    const Core solid = build_piece(hollow, at, i);
    if (norm(b.core.c - solid.c) - solid.bound - b.core.bound - b.radius >= least.distance) continue;
    const Distance d = calc_wall(solid, b);
    if (d.distance < least.distance) least = d;
  }
  return least;
}

Distance mirror(const Distance& d) {
  Distance out = d;
  out.on_a = d.on_b;
  out.on_b = d.on_a;
  out.normal = -d.normal;
  return out;
}

// The lowest point of a wall is that of the solids that it bounds: it lies on their rims.
Distance calc_hollow_half_space(const ShapeView& hollow, const Placed& at, const Placed& space) {
  Distance least;
  for (std::size_t i = 0; i + 1 < hollow.profile.size(); ++i) {
    const Distance d = calc_half_space(space, {build_piece(hollow, at, i), 0});
    if (d.distance < least.distance) least = d;
  }
  return mirror(least);
}

int compare(double a, double b) { return a < b ? -1 : (a > b ? 1 : 0); }
int compare(const Vec3& a, const Vec3& b) {
  if (const int c = compare(a.x, b.x)) return c;
  if (const int c = compare(a.y, b.y)) return c;
  return compare(a.z, b.z);
}
int compare(const Mat3& a, const Mat3& b) {
  if (const int c = compare(a.x, b.x)) return c;
  if (const int c = compare(a.y, b.y)) return c;
  return compare(a.z, b.z);
}

// An order of shapes and places, by kind, sizes and place, so that both orders of the arguments compute the same.
int compare(const ShapeView& view_a, const Placement& at_a, const ShapeView& view_b, const Placement& at_b) {
  const ShapeNumbers &a = view_a.numbers, &b = view_b.numbers;
  if (a.kind != b.kind) return a.kind > b.kind ? -1 : 1;
  if (const int c = compare(a.bound, b.bound)) return c;
  if (const int c = compare(a.r0, b.r0)) return c;
  if (const int c = compare(a.r1, b.r1)) return c;
  if (const int c = compare(a.half_length, b.half_length)) return c;
  if (const int c = compare(a.half_size, b.half_size)) return c;
  const std::span<const Vec3> of_a = view_a.points, of_b = view_b.points;
  if (of_a.size() != of_b.size()) return of_a.size() < of_b.size() ? -1 : 1;
  if (const int c = compare(at_a.p_WB, at_b.p_WB)) return c;
  if (const int c = compare(at_a.R_WB, at_b.R_WB)) return c;
  if (const int c = compare(a.p_BS, b.p_BS)) return c;
  if (const int c = compare(a.R_BS, b.R_BS)) return c;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (const int c = compare(of_a[i], of_b[i])) return c;
  return 0;
}

Distance calc_ordered(const ShapeView& a, const Placement& at_a, const ShapeView& b, const Placement& at_b) {
  const Vec3 origin = at_a.p_WB;
  const Placed place_a = place(a.numbers, at_a, origin);
  const Placed place_b = place(b.numbers, at_b, origin);
  Distance out;
  const bool is_wall = a.numbers.kind == ShapeKind::kHollow || a.numbers.kind == ShapeKind::kHalfSpace;
  if (b.numbers.kind == ShapeKind::kSphere && !is_wall) {
    const Rounded core_a = build_core(a, place_a);
    if (!find_ball(core_a, place_b.c, b.numbers.r0, out)) out = calc_convex(core_a, build_core(b, place_b));
  } else if (b.numbers.kind == ShapeKind::kHalfSpace) {  // A is hollow
    out = calc_hollow_half_space(a, place_a, place_b);
  } else {
    const Rounded core_b = build_core(b, place_b);
    out = a.numbers.kind == ShapeKind::kHollow      ? calc_hollow(a, place_a, core_b)
          : a.numbers.kind == ShapeKind::kHalfSpace ? calc_half_space(place_a, core_b)
                                                    : calc_convex(build_core(a, place_a), core_b);
  }
  out.on_a += origin;
  out.on_b += origin;
  return out;
}

}  // namespace

bool has_distance(ShapeKind a, ShapeKind b) noexcept {
  return a != b || (a != ShapeKind::kHollow && a != ShapeKind::kHalfSpace);
}

Distance calc_distance(const ShapeView& a, const Placement& at_a, const ShapeView& b, const Placement& at_b) noexcept {
  if (!has_distance(a.numbers.kind, b.numbers.kind)) return {};
  if (compare(a, at_a, b, at_b) <= 0) return calc_ordered(a, at_a, b, at_b);
  return mirror(calc_ordered(b, at_b, a, at_a));
}

PairMargins calc_pair_margins(const ShapeView& a, const Placement& at_a, const ShapeView& b, const Placement& at_b,
                              const Distance& d) noexcept {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  constexpr PairMargins kNone{{kUnknown, kUnknown, kUnknown}, {kUnknown, kUnknown, kUnknown}};
  for (const ShapeKind kind : {a.numbers.kind, b.numbers.kind})
    if (kind == ShapeKind::kHull || kind == ShapeKind::kHollow || kind == ShapeKind::kHalfSpace) return kNone;
  const Vec3 origin = at_a.p_WB;
  const Rounded core_a = build_core(a, place(a.numbers, at_a, origin)),
                core_b = build_core(b, place(b.numbers, at_b, origin));
  if (!(d.distance + (core_a.radius + core_b.radius) > 0)) return kNone;
  const Vec3 nearest_a = (d.on_a - origin) - core_a.radius * d.normal,
             nearest_b = (d.on_b - origin) + core_b.radius * d.normal;
  const Margins on_a = calc_margins(core_a.core, nearest_b), on_b = calc_margins(core_b.core, nearest_a);
  return on_a.known && on_b.known ? PairMargins{on_a.of, on_b.of} : kNone;
}

namespace {

// Of a sphere about `centre`, W.
SphereDistance calc_sphere_distance(const Vec3& centre, double radius, const ShapeView& other,
                                    const Placement& at_other) {
  SphereDistance out;
  out.centre = centre;
  const Vec3 origin = at_other.p_WB, x = centre - origin;
  if (other.numbers.kind == ShapeKind::kHalfSpace) {
    const ShapeNumbers& space = other.numbers;
    out.normal = (at_other.R_WB * space.R_BS).z;
    out.distance = dot(out.normal, x - at_other.R_WB * space.p_BS) - radius;
    return out;
  }
  const Rounded solid = build_core(other, place(other.numbers, at_other, origin));
  const Projection nearest = calc_projection(solid.core, x);
  const Vec3 away = x - nearest.p;
  const double D = norm(away);
  out.outside = !nearest.inside && D > 0;
  if (!out.outside) return out;
  out.normal = (1 / D) * away;
  out.bend = 1 / D;
  out.kept = nearest.J;
  out.distance = D - solid.radius - radius;
  return out;
}

// Where along the axis a, from −h to h about its centre, it is nearest to the axis b; `apart` leads from the centre of
// b to that of a. The sum of squares is convex: the best place without ends, moved into them one axis after the other.
double find_nearest_along(const Vec3& a, double h, const Vec3& b, double of_b, const Vec3& apart) {
  const double c = dot(a, b), along_a = dot(apart, a), along_b = dot(apart, b), across = 1 - c * c;
  const double s = across > 0 ? std::clamp((c * along_b - along_a) / across, -h, h) : 0;
  const double t = std::clamp(along_b + s * c, -of_b, of_b);
  return std::clamp(t * c - along_a, -h, h);
}

}  // namespace

SphereDistance calc_sphere_distance(const ShapeView& sphere, const Placement& at_sphere, const ShapeView& other,
                                    const Placement& at_other) noexcept {
  return calc_sphere_distance(at_sphere.p_WB + at_sphere.R_WB * sphere.numbers.p_BS, sphere.numbers.r0, other,
                              at_other);
}

CapsuleDistance calc_capsule_distance(const ShapeView& capsule, const Placement& at_capsule, const ShapeView& other,
                                      const Placement& at_other) noexcept {
  const ShapeNumbers &own = capsule.numbers, &its = other.numbers;
  const Vec3 axis = (at_capsule.R_WB * own.R_BS).z, its_axis = (at_other.R_WB * its.R_BS).z;
  const Vec3 arm = at_capsule.R_WB * own.p_BS;
  const Vec3 apart = (at_capsule.p_WB - at_other.p_WB) + (arm - at_other.R_WB * its.p_BS);
  const double s = find_nearest_along(axis, own.half_length, its_axis, its.half_length, apart);
  const SphereDistance sphere = calc_sphere_distance(at_capsule.p_WB + (arm + s * axis), own.r0, other, at_other);
  return {sphere, std::abs(s) < own.half_length ? axis : Vec3{0, 0, 0}};
}

}  // namespace unlatch::geometry
