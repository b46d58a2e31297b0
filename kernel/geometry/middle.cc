#include "kernel/geometry/middle.h"

#include <initializer_list>

#include "unlatch/elementary.h"

namespace unlatch::geometry {
namespace {

constexpr double kParallel = 1e-10;  // rad
constexpr int kMostCorners = 512;    // of two faces of hulls
constexpr double kPi = 3.14159265358979323846;

struct Point2 {
  double x, y;
};
Point2 operator-(Point2 a, Point2 b) { return {a.x - b.x, a.y - b.y}; }
double cross2(Point2 a, Point2 b) { return a.x * b.y - a.y * b.x; }
double dot2(Point2 a, Point2 b) { return a.x * b.x + a.y * b.y; }
Point2 lerp(Point2 a, Point2 b, double t) { return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}; }

// A face, seen along the normal: nothing (a point), a line, a polygon (counterclockwise), or a disc.
struct Region {
  enum class Kind { kPoint, kLine, kPolygon, kDisc };
  Kind kind = Kind::kPoint;
  Point2 corners[kMostCorners];
  int count = 0;
  Point2 centre{0, 0};
  double radius = 0;
};

// Plane across n through `origin`.
struct Plane {
  Vec3 origin, u, v;
  Point2 see(const Vec3& p) const { return {dot(p - origin, u), dot(p - origin, v)}; }
};

void add_corner(Region& region, const Point2& p) {
  if (region.count < kMostCorners) region.corners[region.count++] = p;
}

void close_polygon(Region& region) {
  region.kind = region.count >= 3   ? Region::Kind::kPolygon
                : region.count == 2 ? Region::Kind::kLine
                                    : Region::Kind::kPoint;
  if (region.kind != Region::Kind::kPolygon) return;
  double area = 0;
  for (int i = 1; i + 1 < region.count; ++i)
    area += cross2(region.corners[i] - region.corners[0], region.corners[i + 1] - region.corners[0]);
  if (area < 0) {
    for (int i = 0; i < region.count / 2; ++i) {
      const Point2 p = region.corners[i];
      region.corners[i] = region.corners[region.count - 1 - i];
      region.corners[region.count - 1 - i] = p;
    }
  }
}

// Convex hull of the corners by wrapping (Jarvis 1973).
void wrap(Region& region, double size) {
  const double tolerance = 1e-13 * size * size;
  Point2 all[kMostCorners];
  const int count = region.count;
  for (int i = 0; i < count; ++i) all[i] = region.corners[i];
  int first = 0;
  for (int i = 1; i < count; ++i)
    if (all[i].x < all[first].x || (all[i].x == all[first].x && all[i].y < all[first].y)) first = i;
  region.count = 0;
  int at = first;
  for (int step = 0; step < count; ++step) {
    add_corner(region, all[at]);
    int next = -1;
    for (int i = 0; i < count; ++i) {
      const Point2 e = all[i] - all[at];
      if (dot2(e, e) <= tolerance) continue;
      if (next < 0) {
        next = i;
        continue;
      }
      const Point2 best = all[next] - all[at];
      const double turn = cross2(best, e);
      if (turn < -tolerance || (turn <= tolerance && dot2(e, e) > dot2(best, best))) next = i;
    }
    if (next < 0 || next == first) break;
    const Point2 back = all[next] - all[first];
    if (dot2(back, back) <= tolerance) break;
    at = next;
  }
}

void see_frustum(const Core& core, const Vec3& n, const Plane& plane, Region& region) {
  const Vec3 l = transpose_times(core.R, n);
  const double across = std::sqrt(l.x * l.x + l.y * l.y);
  if (across <= kParallel) {
    const bool top = l.z > 0;
    const double r = top ? core.r1 : core.r0;
    if (!(r > 0)) return;
    const Vec3 centre{0, 0, top ? core.h : -core.h};
    if (core.kind == Core::Kind::kFrustum) {
      region.kind = Region::Kind::kDisc;
      region.centre = plane.see(to_pair(core, centre));
      region.radius = r;
      return;
    }
    constexpr int kSides = 32;  // of the half circle
    for (int i = 0; i <= kSides; ++i) {
      double s, c;
      elementary::sincos(kPi * (static_cast<double>(i) / kSides - 0.5), s, c);
      add_corner(region, plane.see(to_pair(core, {r * c, r * s, centre.z})));
    }
    return close_polygon(region);
  }
  const bool half = core.kind == Core::Kind::kHalfFrustum;
  if (half && l.x <= kParallel) {
    if (l.x < 0 && across + l.x <= kParallel * kParallel && std::fabs(l.y) <= kParallel &&
        std::fabs(l.z) <= kParallel) {
      for (const Vec3& p :
           {Vec3{0, -core.r0, -core.h}, Vec3{0, core.r0, -core.h}, Vec3{0, core.r1, core.h}, Vec3{0, -core.r1, core.h}})
        add_corner(region, plane.see(to_pair(core, p)));
      return close_polygon(region);
    }
  }
  const double reach = half && l.x <= 0 ? std::fabs(l.y) : across;
  if (std::fabs(reach * core.gr + l.z * core.gz) > kParallel) return;
  const double ex = half && l.x <= 0 ? 0.0 : l.x / across,
               ey = half && l.x <= 0 ? (l.y < 0 ? -1.0 : 1.0) : l.y / across;
  add_corner(region, plane.see(to_pair(core, {core.r0 * ex, core.r0 * ey, -core.h})));
  add_corner(region, plane.see(to_pair(core, {core.r1 * ex, core.r1 * ey, core.h})));
  close_polygon(region);
}

void project_face(const Core& core, const Vec3& n, double size, const Plane& plane, Region& region) {
  switch (core.kind) {
    case Core::Kind::kPoint:
      return;
    case Core::Kind::kSegment:
      if (std::fabs(dot(core.R.z, n)) > kParallel) return;
      add_corner(region, plane.see(to_pair(core, {0, 0, -core.h})));
      add_corner(region, plane.see(to_pair(core, {0, 0, core.h})));
      return close_polygon(region);
    case Core::Kind::kFrustum:
    case Core::Kind::kHalfFrustum:
      return see_frustum(core, n, plane, region);
    case Core::Kind::kBox: {
      const Vec3 l = transpose_times(core.R, n);
      const double part[3] = {l.x, l.y, l.z}, half[3] = {core.half.x, core.half.y, core.half.z};
      double low[3], high[3];
      int free[3] = {0, 0, 0}, count = 0;
      for (int i = 0; i < 3; ++i) {
        const bool is_free = std::fabs(part[i]) <= kParallel;
        low[i] = is_free || part[i] < 0 ? -half[i] : half[i];
        high[i] = is_free || part[i] > 0 ? half[i] : -half[i];
        if (is_free) free[count++] = i;
      }
      if (count == 0) return;
      const bool high_ends[4][2] = {{false, false}, {true, false}, {true, true}, {false, true}};
      for (int k = 0; k < (count == 1 ? 2 : 4); ++k) {
        double p[3] = {low[0], low[1], low[2]};
        p[free[0]] = high_ends[k][0] ? high[free[0]] : low[free[0]];
        if (count == 2) p[free[1]] = high_ends[k][1] ? high[free[1]] : low[free[1]];
        add_corner(region, plane.see(to_pair(core, {p[0], p[1], p[2]})));
      }
      return close_polygon(region);
    }
    case Core::Kind::kPoints: {
      const Vec3 l = transpose_times(core.R, n);
      double most = dot(l, core.points[0]);
      for (int i = 1; i < core.count; ++i) {
        const double value = dot(l, core.points[i]);
        if (value > most) most = value;
      }
      for (int i = 0; i < core.count; ++i) {
        if (most - dot(l, core.points[i]) <= kParallel * size)
          add_corner(region, plane.see(to_pair(core, core.points[i])));
      }
      if (region.count >= 2) wrap(region, size);
      return close_polygon(region);
    }
  }
}

// [low, high] of the parameter of the line p + t e inside a region.
bool clip_line(const Region& region, Point2 p, Point2 e, double& low, double& high) {
  if (region.kind == Region::Kind::kDisc) {
    const Point2 d = p - region.centre;
    const double a = dot2(e, e), b = dot2(d, e), c = dot2(d, d) - region.radius * region.radius, root = b * b - a * c;
    if (!(root > 0)) return false;
    const double s = std::sqrt(root), t0 = (-b - s) / a, t1 = (-b + s) / a;
    if (t0 > low) low = t0;
    if (t1 < high) high = t1;
    return high > low;
  }
  for (int i = 0; i < region.count; ++i) {
    const Point2 from = region.corners[i], side = region.corners[(i + 1) % region.count] - from;
    const double at = cross2(side, p - from), rate = cross2(side, e);  // inside: at + t rate >= 0
    if (rate > 0) {
      if (-at / rate > low) low = -at / rate;
    } else if (rate < 0) {
      if (-at / rate < high) high = -at / rate;
    } else if (at < 0) {
      return false;
    }
  }
  return high > low;
}

// Sutherland and Hodgman 1974.
void clip_polygon(Region& subject, const Region& clip) {
  for (int i = 0; i < clip.count && subject.count > 0; ++i) {
    const Point2 from = clip.corners[i], side = clip.corners[(i + 1) % clip.count] - from;
    Point2 all[kMostCorners];
    const int count = subject.count;
    for (int k = 0; k < count; ++k) all[k] = subject.corners[k];
    subject.count = 0;
    for (int k = 0; k < count; ++k) {
      const Point2 p = all[k], q = all[(k + 1) % count];
      const double at_p = cross2(side, p - from), at_q = cross2(side, q - from);
      if (at_p >= 0) add_corner(subject, p);
      if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0)) add_corner(subject, lerp(p, q, at_p / (at_p - at_q)));
    }
  }
}

// Area and first moments.
struct Area {
  double area = 0, x = 0, y = 0;
  void add_triangle(Point2 p, Point2 q) {  // with the origin
    const double twice = cross2(p, q);
    area += 0.5 * twice;
    x += twice * (p.x + q.x) / 6;
    y += twice * (p.y + q.y) / 6;
  }
  // Adds the sector of a disc about the origin between the directions p and q, less than half a turn.
  void add_sector(Point2 p, Point2 q, double radius) {
    const double angle = elementary::atan2(cross2(p, q), dot2(p, q));
    const double lp = std::sqrt(dot2(p, p)), lq = std::sqrt(dot2(q, q)), cube = radius * radius * radius / 3;
    area += 0.5 * radius * radius * angle;
    x += cube * (q.y / lq - p.y / lp);
    y -= cube * (q.x / lq - p.x / lp);
  }
};

bool centre_of_polygon(const Region& region, Point2& centre) {
  Area sum;
  const Point2 o = region.corners[0];
  for (int i = 1; i + 1 < region.count; ++i) sum.add_triangle(region.corners[i] - o, region.corners[i + 1] - o);
  if (region.count < 3 || !(sum.area > 0)) return false;
  centre = {o.x + sum.x / sum.area, o.y + sum.y / sum.area};
  return true;
}

bool centre_of_polygon_and_disc(const Region& polygon, const Region& disc, Point2& centre) {
  Area sum;
  const double radius = disc.radius;
  for (int i = 0; i < polygon.count; ++i) {
    const Point2 p = polygon.corners[i] - disc.centre, q = polygon.corners[(i + 1) % polygon.count] - disc.centre;
    const Point2 e = q - p;
    const double a = dot2(e, e), b = dot2(p, e), c = dot2(p, p) - radius * radius, root = b * b - a * c;
    if (!(a > 0)) continue;
    if (!(root > 0)) {
      sum.add_sector(p, q, radius);
      continue;
    }
    const double s = std::sqrt(root), t0 = (-b - s) / a, t1 = (-b + s) / a;
    const double from = t0 < 0 ? 0 : (t0 > 1 ? 1 : t0), to = t1 < 0 ? 0 : (t1 > 1 ? 1 : t1);
    const Point2 enter = lerp(p, q, from), leave = lerp(p, q, to);
    if (from > 0) sum.add_sector(p, enter, radius);
    if (to > from) sum.add_triangle(enter, leave);
    if (to < 1) sum.add_sector(leave, q, radius);
  }
  if (!(sum.area > 0)) return false;
  centre = {disc.centre.x + sum.x / sum.area, disc.centre.y + sum.y / sum.area};
  return true;
}

// The common region is a lens, or the smaller disc where it lies in the larger.
bool centre_of_discs(const Region& a, const Region& b, Point2& centre) {
  const Point2 way = b.centre - a.centre;
  const double d = std::sqrt(dot2(way, way)), ra = a.radius, rb = b.radius;
  if (d >= ra + rb) return false;
  if (d <= std::fabs(ra - rb)) return centre = ra < rb ? a.centre : b.centre, true;
  const double x = 0.5 * (d + (ra - rb) * ((ra + rb) / d));  // of the chord, from a's centre
  const double half = std::sqrt(ra * ra - x * x > 0 ? ra * ra - x * x : 0.0), cube = 2.0 / 3 * half * half * half;
  const double of_a = elementary::atan2(half, x), of_b = elementary::atan2(half, d - x);
  const double part_a = ra * ra * of_a - half * x,
               part_b = rb * rb * of_b - half * (d - x);  // segments beyond the chord
  const double area = part_a + part_b;
  if (!(area > 0)) return false;
  // First moments of the two segments, each about its disc's centre: `cube` towards b, and `cube` towards a.
  const double along = (cube + (part_b * d - cube)) / area;
  centre = lerp(a.centre, b.centre, along / d);
  return true;
}

bool find_middle(Region& a, Region& b, Point2& middle) {
  using Kind = Region::Kind;
  if (a.kind == Kind::kPoint || b.kind == Kind::kPoint) return false;
  if (a.kind == Kind::kLine || b.kind == Kind::kLine) {
    const Region& line = a.kind == Kind::kLine ? a : b;
    const Region& other = a.kind == Kind::kLine ? b : a;
    const Point2 p = line.corners[0], e = line.corners[1] - p;
    const double length = dot2(e, e);
    double low = 0, high = 1;
    if (other.kind == Kind::kLine) {
      const Point2 f = other.corners[1] - other.corners[0];
      if (std::fabs(cross2(e, f)) > kParallel * std::sqrt(length * dot2(f, f))) return false;
      double t0 = dot2(other.corners[0] - p, e) / length, t1 = dot2(other.corners[1] - p, e) / length;
      if (t0 > t1) {
        const double t = t0;
        t0 = t1, t1 = t;
      }
      if (t0 > low) low = t0;
      if (t1 < high) high = t1;
      if (!(high > low)) return false;
    } else if (!clip_line(other, p, e, low, high)) {
      return false;
    }
    middle = lerp(p, line.corners[1], 0.5 * (low + high));
    return true;
  }
  if (a.kind == Kind::kDisc && b.kind == Kind::kDisc) return centre_of_discs(a, b, middle);
  if (a.kind == Kind::kDisc) return centre_of_polygon_and_disc(b, a, middle);
  if (b.kind == Kind::kDisc) return centre_of_polygon_and_disc(a, b, middle);
  clip_polygon(a, b);
  return centre_of_polygon(a, middle);
}

// A quick test: most pairs have no face across the normal.
bool has_face(const Core& core, const Vec3& n) {
  if (core.kind == Core::Kind::kPoint) return false;
  if (core.kind == Core::Kind::kPoints) return true;
  const Vec3 l = transpose_times(core.R, n);
  if (core.kind == Core::Kind::kSegment) return std::fabs(l.z) <= kParallel;
  if (core.kind == Core::Kind::kBox)
    return std::fabs(l.x) <= kParallel || std::fabs(l.y) <= kParallel || std::fabs(l.z) <= kParallel;
  const double across = std::sqrt(l.x * l.x + l.y * l.y);
  return core.kind == Core::Kind::kHalfFrustum || across <= kParallel ||
         std::fabs(across * core.gr + l.z * core.gz) <= kParallel;
}

}  // namespace

void move_to_middle(const Core& A, const Core& B, const Vec3& n, double size, Vec3& a, Vec3& b) {
  if (A.kind == Core::Kind::kPoint || B.kind == Core::Kind::kPoint || !has_face(A, n) || !has_face(B, -n)) return;
  Plane plane;
  plane.origin = a;
  plane.u = calc_across(n);
  plane.v = cross(n, plane.u);
  Region of_a, of_b;
  project_face(A, n, size, plane, of_a);
  if (of_a.kind == Region::Kind::kPoint) return;
  project_face(B, -n, size, plane, of_b);
  Point2 middle{0, 0};
  if (!find_middle(of_a, of_b, middle)) return;
  const Vec3 way = middle.x * plane.u + middle.y * plane.v;
  a += way;
  b += way;
}

}  // namespace unlatch::geometry
