#include "kernel/geometry/core.h"

#include "kernel/geometry/gjk.h"

namespace unlatch::geometry {
namespace {

// Nearest point of the meridian polygon (0,−h), (r0,−h), (r1,h), (0,h) to (rho, z), rho ≥ 0.
struct Meridian {
  enum class Region { kInside, kDisc, kSide, kRim };
  Region region = Region::kInside;
  double rho = 0, z = 0;
};

Meridian calc_meridian(const Core& f, double rho, double z) {
  using Region = Meridian::Region;
  if (z < -f.h && rho <= f.r0) return {Region::kDisc, rho, -f.h};
  if (z > f.h && rho <= f.r1) return {Region::kDisc, rho, f.h};
  const double dr = rho - f.r0, dz = z + f.h;
  const double u = dr * f.gr + dz * f.gz, v = dr * f.gz - dz * f.gr;
  if (v <= 0 && std::fabs(z) <= f.h) return {Region::kInside, rho, z};
  if (u <= 0) return {Region::kRim, f.r0, -f.h};
  if (u >= f.length) return {Region::kRim, f.r1, f.h};
  return {Region::kSide, f.r0 + u * f.gr, u * f.gz - f.h};
}

Projection project_frustum(const Core& f, const Vec3& x, const Vec3& l) {
  const double rho = std::sqrt(l.x * l.x + l.y * l.y);
  const Meridian m = calc_meridian(f, rho, l.z);
  if (m.region == Meridian::Region::kInside) return {x, {}, true};
  if (m.region == Meridian::Region::kDisc) return {x + (m.z - l.z) * f.R.z, {f.R.x, f.R.y, 1, 1}, false};
  const double inverse = rho > 0 ? 1.0 / rho : 0.0;
  const double ex = rho > 0 ? l.x * inverse : 1.0, ey = l.y * inverse;
  const Vec3 e = ex * f.R.x + ey * f.R.y, t = ex * f.R.y - ey * f.R.x;
  const bool side = m.region == Meridian::Region::kSide;
  return {f.c + (m.rho * e + m.z * f.R.z),
          {side ? f.gr * e + f.gz * f.R.z : e, t, side ? 1.0 : 0.0, m.rho * inverse},
          false};
}

// The half with x ≥ 0: the whole frustum's projection if it lies there, else that onto the plane x = 0, where the
// section is the meridian polygon and its mirror image.
Projection project_half(const Core& f, const Vec3& x, const Vec3& l) {
  const Projection whole = project_frustum(f, x, l);
  if (dot(f.R.x, whole.p - f.c) >= 0) return whole;
  const double side = l.y < 0 ? -1 : 1;
  const Meridian m = calc_meridian(f, std::fabs(l.y), l.z);
  Projection out;
  out.p = f.c + ((side * m.rho) * f.R.y + m.z * f.R.z);
  switch (m.region) {
    case Meridian::Region::kInside:
      out.J = {f.R.y, f.R.z, 1, 1};
      break;
    case Meridian::Region::kDisc:
      out.J = {f.R.y, f.R.z, 1, 0};
      break;
    case Meridian::Region::kSide:
      out.J = {(side * f.gr) * f.R.y + f.gz * f.R.z, f.R.x, 1, 0};
      break;
    case Meridian::Region::kRim:
      break;
  }
  return out;
}

double clamp(double x, double limit) { return x < -limit ? -limit : (x > limit ? limit : x); }

Projection project_box(const Core& box, const Vec3& l) {
  Projection out;
  out.p = {clamp(l.x, box.half.x), clamp(l.y, box.half.y), clamp(l.z, box.half.z)};
  const bool x = out.p.x == l.x, y = out.p.y == l.y, z = out.p.z == l.z;
  out.inside = x && y && z;
  out.J.u1 = x ? Vec3{1, 0, 0} : (y ? Vec3{0, 1, 0} : Vec3{0, 0, 1});
  out.J.u2 = x && y ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  out.J.l1 = x || y || z ? 1 : 0;
  out.J.l2 = (x && y) || (y && z) || (x && z) ? 1 : 0;
  return out;
}

Projection project_points(const Core& hull, const Vec3& x) {
  Core point;
  point.c = x;
  const Gjk found = calc_gjk(point, hull, hull.c - x);
  Projection out;
  out.p = found.overlap ? x : found.b;
  out.inside = found.overlap;
  if (!found.overlap && found.count >= 2) {
    const Vec3 e = found.w[1] - found.w[0];
    const double length = norm(e);
    out.J.u1 = (1.0 / length) * e;
    out.J.l1 = 1;
    if (found.count == 3) {
      const Vec3 d = found.w[2] - found.w[0];
      const Vec3 across = d - dot(d, out.J.u1) * out.J.u1;
      out.J.u2 = (1.0 / norm(across)) * across;
      out.J.l2 = 1;
    }
  }
  return out;
}

}  // namespace

void update_generator(Core& core) {
  const double dr = core.r1 - core.r0, dz = 2 * core.h;
  core.length = std::sqrt(dr * dr + dz * dz);
  core.gr = dr / core.length;
  core.gz = dz / core.length;
}

Vec3 calc_support(const Core& core, const Vec3& d) {
  switch (core.kind) {
    case Core::Kind::kPoint:
      return core.c;
    case Core::Kind::kSegment: {
      const double t = dot(core.R.z, d) >= 0 ? core.h : -core.h;
      return core.c + t * core.R.z;
    }
    case Core::Kind::kFrustum: {
      const Vec3 l = transpose_times(core.R, d);
      const double across = std::sqrt(l.x * l.x + l.y * l.y);
      const bool top = (core.r1 - core.r0) * across + 2 * core.h * l.z >= 0;
      const double r = top ? core.r1 : core.r0, k = across > 0 ? r / across : 0.0;
      return to_pair(core, {k * l.x, k * l.y, top ? core.h : -core.h});
    }
    case Core::Kind::kHalfFrustum: {
      const Vec3 l = transpose_times(core.R, d);
      const double across = l.x > 0 ? std::sqrt(l.x * l.x + l.y * l.y) : std::fabs(l.y);
      const bool top = (core.r1 - core.r0) * across + 2 * core.h * l.z >= 0;
      const double r = top ? core.r1 : core.r0, k = across > 0 ? r / across : 0.0;
      return to_pair(core, {l.x > 0 ? k * l.x : 0.0, k * l.y, top ? core.h : -core.h});
    }
    case Core::Kind::kBox: {
      const Vec3 l = transpose_times(core.R, d);
      return to_pair(core, {l.x >= 0 ? core.half.x : -core.half.x, l.y >= 0 ? core.half.y : -core.half.y,
                            l.z >= 0 ? core.half.z : -core.half.z});
    }
    case Core::Kind::kPoints:
      break;
  }
  const Vec3 l = transpose_times(core.R, d);
  int best = 0;
  double most = dot(l, core.points[0]);
  for (int i = 1; i < core.count; ++i) {
    const double value = dot(l, core.points[i]);
    if (value > most) most = value, best = i;
  }
  return to_pair(core, core.points[best]);
}

Projection calc_projection(const Core& core, const Vec3& x) {
  Projection out;
  const Vec3 l = to_local(core, x);
  switch (core.kind) {
    case Core::Kind::kPoint:
      out.p = core.c;
      return out;
    case Core::Kind::kSegment: {
      const double t = clamp(l.z, core.h);
      out.p = core.c + t * core.R.z;
      out.J.u1 = core.R.z;
      out.J.l1 = t == l.z ? 1 : 0;
      return out;
    }
    case Core::Kind::kFrustum:
      return project_frustum(core, x, l);
    case Core::Kind::kHalfFrustum:
      return project_half(core, x, l);
    case Core::Kind::kBox:
      out = project_box(core, l);
      break;
    case Core::Kind::kPoints:
      return project_points(core, x);
  }
  out.p = out.inside ? x : to_pair(core, out.p);
  out.J.u1 = core.R * out.J.u1;
  out.J.u2 = core.R * out.J.u2;
  return out;
}

Margins calc_margins(const Core& core, const Vec3& x) {
  const Vec3 l = to_local(core, x);
  switch (core.kind) {
    case Core::Kind::kPoint:
      return {{1, 1, 1}, true};
    case Core::Kind::kSegment:
      return {{std::fabs(l.z) - core.h, 1, 1}, true};
    case Core::Kind::kBox: {
      const Vec3 beyond{std::fabs(l.x) - core.half.x, std::fabs(l.y) - core.half.y, std::fabs(l.z) - core.half.z};
      return {beyond, beyond.x > 0 || beyond.y > 0 || beyond.z > 0};
    }
    case Core::Kind::kFrustum: {
      const double rho = std::sqrt(l.x * l.x + l.y * l.y);
      const double along = (rho - core.r0) * core.gr + (l.z + core.h) * core.gz;
      const bool ends = std::fabs(l.z) > core.h;
      return {{along, along - core.length, ends ? rho - (l.z < 0 ? core.r0 : core.r1) : 1},
              calc_meridian(core, rho, l.z).region != Meridian::Region::kInside};
    }
    default:
      return {};
  }
}

}  // namespace unlatch::geometry
