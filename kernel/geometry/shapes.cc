// Mistakes of shapes, their compilation, and their unions.
#include <cmath>
#include <limits>
#include <utility>

#include "kernel/geometry/compiled_shape.h"
#include "kernel/geometry/core.h"
#include "kernel/math/number_text.h"
#include "unlatch/geometry/group_pair.h"

namespace unlatch::geometry {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kFlat = 1e-9;  // of the size: a hull that is thinner has no volume

std::string count_points(std::size_t count) { return std::to_string(count) + (count == 1 ? " point" : " points"); }

bool is_finite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

class Checker {
 public:
  explicit Checker(const Shape& shape) : shape_(shape) {}

  std::vector<ShapeError> check() {
    check_vector("from", shape_.from);
    switch (shape_.kind) {
      case ShapeKind::kSphere:
        check_radius("radius", shape_.radius, false);
        break;
      case ShapeKind::kCapsule:
        check_axis();
        check_radius("radius", shape_.radius, true);
        break;
      case ShapeKind::kCylinder:
      case ShapeKind::kCone:
        check_axis();
        check_radius("radius", shape_.radius, false);
        break;
      case ShapeKind::kFrustum:
        check_axis();
        check_radius("radius", shape_.radius, true);
        check_radius("end_radius", shape_.end_radius, true);
        if (shape_.radius == 0 && shape_.end_radius == 0)
          add("radius", "a frustum without volume: both radii are 0", "at least one radius greater than 0");
        break;
      case ShapeKind::kBox:
        check_box();
        break;
      case ShapeKind::kHull:
        check_hull();
        break;
      case ShapeKind::kHalfSpace:
        if (!is_finite(shape_.normal) || !(dot(shape_.normal, shape_.normal) > 0))
          add("normal", "normal is not a direction", "a finite vector that is not 0, out of the half-space");
        break;
      case ShapeKind::kHollow:
        check_hollow();
        break;
    }
    return std::move(errors_);
  }

 private:
  void add(std::string key, std::string what, std::string mend) {
    errors_.push_back({std::move(key), std::move(what), std::move(mend)});
  }

  void check_vector(const char* key, const Vec3& v) {
    if (!is_finite(v)) add(key, std::string(key) + " is not finite", "three finite numbers, in m");
  }

  void check_radius(const char* key, double r, bool zero) {
    if (!std::isfinite(r) || r < 0 || (r == 0 && !zero))
      add(key, std::string(key) + " is " + show(r), zero ? "0 m or more, and finite" : "greater than 0 m, and finite");
  }

  void check_axis() {
    check_vector("to", shape_.to);
    if (is_finite(shape_.from) && is_finite(shape_.to)) {
      const double length = norm(shape_.to - shape_.from);
      if (!(length > 0) || !std::isfinite(length))
        add("to", "the axis from–to has length " + show(length), "two different points; a sphere has no axis");
    }
  }

  void check_box() {
    const Vec3& size = shape_.size;
    if (!is_finite(size) || !(size.x > 0) || !(size.y > 0) || !(size.z > 0))
      add("size", "a box of " + show(size.x) + " × " + show(size.y) + " × " + show(size.z) + " m",
          "three edge lengths greater than 0, and finite");
    const double q = norm_squared(shape_.q_BS);
    if (!std::isfinite(q) || !(q > 0))
      add("attitude", "the attitude is no rotation", "a finite quaternion that is not 0");
  }

  void check_hull() {
    const std::vector<Vec3>& points = shape_.points;
    if (points.size() < 4 || points.size() > static_cast<std::size_t>(kMaxHullPoints)) {
      add("points", "a hull of " + count_points(points.size()), "4 to " + std::to_string(kMaxHullPoints) + " points");
      return;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!is_finite(points[i])) {
        add("points", "point " + std::to_string(i + 1) + " of the hull is not finite", "three finite numbers, in m");
        return;
      }
    }
    // The farthest from the first point, from that line, from that plane.
    double length = 0, height = 0, depth = 0;
    Vec3 e{0, 0, 0}, n{0, 0, 0};
    for (const Vec3& p : points)
      if (const Vec3 d = p - points[0]; norm(d) > length) length = norm(d), e = d;
    for (const Vec3& p : points)
      if (const Vec3 d = cross(e, p - points[0]); norm(d) > height) height = norm(d), n = d;
    for (const Vec3& p : points)
      if (const double d = std::fabs(dot(n, p - points[0])); d > depth) depth = d;
    if (!(depth > kFlat * length * height))
      add("points", "a hull without volume: its points lie in a plane",
          "at least one point off the plane of the others");
  }

  void check_hollow() {
    check_axis();
    const std::vector<ProfilePoint>& profile = shape_.profile;
    if (profile.size() < 2 || profile.size() > static_cast<std::size_t>(kMaxProfilePoints)) {
      add("profile", "a profile of " + count_points(profile.size()),
          "2 to " + std::to_string(kMaxProfilePoints) + " points (z, r)");
      return;
    }
    for (std::size_t i = 0; i < profile.size(); ++i) {
      const std::string point = "point " + std::to_string(i + 1) + " of the profile ";
      if (!std::isfinite(profile[i].z) || !std::isfinite(profile[i].r) || profile[i].r < 0)
        return add("profile", point + "is (" + show(profile[i].z) + ", " + show(profile[i].r) + ")",
                   "finite z, and r of 0 m or more");
      if (i > 0 && !(profile[i].z > profile[i - 1].z))
        return add("profile", point + "is not beyond the one before it", "z that increases from point to point");
      if (i > 0 && profile[i].r == 0 && profile[i - 1].r == 0)
        return add("profile", point + "and the one before it lie on the axis", "r greater than 0 at one of them");
    }
    if (shape_.half && is_finite(shape_.from) && is_finite(shape_.to)) {
      const Vec3 axis = shape_.to - shape_.from;
      if (!is_finite(shape_.side) || !(norm(cross(axis, shape_.side)) > kFlat * norm(axis) * norm(shape_.side)))
        add("side", "side lies along the axis, or is no direction", "from the axis to the middle of the half");
    }
  }

  const Shape& shape_;
  std::vector<ShapeError> errors_;
};

Mat3 build_axes(const Vec3& along) {
  Mat3 R;
  R.z = (1.0 / norm(along)) * along;
  R.x = calc_across(R.z);
  R.y = cross(R.z, R.x);
  return R;
}

double larger(double a, double b) { return a > b ? a : b; }
double hypotenuse(double a, double b) { return std::sqrt(a * a + b * b); }

}  // namespace

std::vector<ShapeError> check_shape(const Shape& shape) { return Checker(shape).check(); }

CompiledShape compile_shape(const Shape& shape) {
  CompiledShape out;
  out.kind = shape.kind;
  out.p_BS = shape.from;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      out.r0 = out.bound = shape.radius;
      return out;
    case ShapeKind::kBox:
      out.R_BS = rotation_matrix(shape.q_BS);
      out.half_size = 0.5 * shape.size;
      out.bound = norm(out.half_size);
      return out;
    case ShapeKind::kHull: {
      Vec3 low = shape.points.front(), high = low;
      for (const Vec3& p : shape.points) {
        low = {p.x < low.x ? p.x : low.x, p.y < low.y ? p.y : low.y, p.z < low.z ? p.z : low.z};
        high = {p.x > high.x ? p.x : high.x, p.y > high.y ? p.y : high.y, p.z > high.z ? p.z : high.z};
      }
      out.p_BS = 0.5 * (low + high);
      for (const Vec3& p : shape.points) {
        out.points.push_back(p - out.p_BS);
        out.bound = larger(out.bound, norm(out.points.back()));
      }
      return out;
    }
    case ShapeKind::kHalfSpace:
      out.R_BS = build_axes(shape.normal);
      out.bound = std::numeric_limits<double>::infinity();
      return out;
    case ShapeKind::kHollow: {
      out.R_BS = build_axes(shape.to - shape.from);
      if (shape.half) {
        const Vec3 side = shape.side - dot(shape.side, out.R_BS.z) * out.R_BS.z;
        out.R_BS.x = (1.0 / norm(side)) * side;
        out.R_BS.y = cross(out.R_BS.z, out.R_BS.x);
        out.half = true;
      }
      const double middle = 0.5 * (shape.profile.front().z + shape.profile.back().z);
      out.p_BS = shape.from + middle * out.R_BS.z;
      for (const ProfilePoint& p : shape.profile) {
        out.profile.push_back({p.z - middle, p.r});
        out.bound = larger(out.bound, hypotenuse(p.z - middle, p.r));
      }
      out.half_length = out.profile.back().z;
      return out;
    }
    default:
      break;
  }
  const Vec3 axis = shape.to - shape.from;
  out.R_BS = build_axes(axis);
  out.p_BS = 0.5 * (shape.from + shape.to);
  out.half_length = 0.5 * norm(axis);
  out.r0 = out.r1 = shape.radius;
  if (shape.kind == ShapeKind::kCapsule) {
    out.bound = out.half_length + out.r0;
    return out;
  }
  out.kind = ShapeKind::kFrustum;
  if (shape.kind == ShapeKind::kCone) out.r1 = 0;
  if (shape.kind == ShapeKind::kFrustum) out.r1 = shape.end_radius;
  out.bound = hypotenuse(out.half_length, larger(out.r0, out.r1));
  Core core;
  core.h = out.half_length, core.r0 = out.r0, core.r1 = out.r1;
  update_generator(core);
  out.slope_r = core.gr, out.slope_z = core.gz, out.generator = core.length;
  return out;
}

ShapeGroup build_group(std::string name, std::span<const Shape> shapes) {
  ShapeGroup group;
  group.name = std::move(name);
  std::vector<CompiledShape> parts;
  for (const Shape& shape : shapes) parts.push_back(compile_shape(shape));
  group.parts = std::make_shared<const std::vector<CompiledShape>>(std::move(parts));
  // About the middle of the parts' bounding boxes.
  Vec3 low{kInfinite, kInfinite, kInfinite}, high = -low;
  for (const CompiledShape& s : *group.parts) {
    if (!std::isfinite(s.bound)) {
      group.bound = kInfinite;
      return group;
    }
    const Vec3 b{s.bound, s.bound, s.bound}, l = s.p_BS - b, h = s.p_BS + b;
    low = {std::fmin(low.x, l.x), std::fmin(low.y, l.y), std::fmin(low.z, l.z)};
    high = {std::fmax(high.x, h.x), std::fmax(high.y, h.y), std::fmax(high.z, h.z)};
  }
  if (group.parts->empty()) return group;
  group.centre = 0.5 * (low + high);
  for (const CompiledShape& s : *group.parts)
    group.bound = std::fmax(group.bound, norm(s.p_BS - group.centre) + s.bound);
  return group;
}

GroupPair::GroupPair(ShapeGroup a, ShapeGroup b)
    : a_(std::move(a)),
      b_(std::move(b)),
      bounds_(get_parts(a_).size() * get_parts(b_).size(), -std::numeric_limits<double>::infinity()) {}

}  // namespace unlatch::geometry
