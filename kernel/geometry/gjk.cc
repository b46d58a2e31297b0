#include "kernel/geometry/gjk.h"

#include <cmath>

namespace unlatch::geometry {
namespace {

constexpr int kMostIterations = 96;  // hulls of 256 points take some 20
constexpr double kRelative = 4e-16;  // of the pair's size: nearer is an overlap, smaller gains are rounding

struct Nearest {
  Vec3 v{0, 0, 0};
  double squared = 0;
  int index[4] = {0, 0, 0, 0};
  double weight[4] = {0, 0, 0, 0};
  int count = 0;
  bool inside = false;
};

void take(Nearest& best, const Nearest& other) {
  if (best.count == 0 || other.squared < best.squared) best = other;
}

Nearest of_point(const Vec3* w, int i) {
  Nearest out;
  out.v = w[i];
  out.squared = dot(out.v, out.v);
  out.index[0] = i;
  out.weight[0] = 1;
  out.count = 1;
  return out;
}

Nearest of_segment(const Vec3* w, int i, int j) {
  const Vec3 e = w[j] - w[i];
  const double length = dot(e, e), t = -dot(w[i], e);
  if (!(t > 0)) return of_point(w, i);
  if (!(t < length)) return of_point(w, j);
  Nearest out;
  const double s = t / length;
  out.v = w[i] + s * e;
  out.squared = dot(out.v, out.v);
  out.index[0] = i, out.index[1] = j;
  out.weight[0] = 1 - s, out.weight[1] = s;
  out.count = 2;
  return out;
}

Nearest of_triangle(const Vec3* w, int i, int j, int k) {
  const Vec3 a = w[i], b = w[j], c = w[k];
  const Vec3 n = cross(b - a, c - a);
  const double area = dot(n, n);
  Nearest out;
  if (area > 0) {
    const Vec3 p = (dot(a, n) / area) * n;
    const Vec3 pa = a - p, pb = b - p, pc = c - p;
    const double x = dot(cross(pb, pc), n), y = dot(cross(pc, pa), n), z = dot(cross(pa, pb), n);
    if (x > 0 && y > 0 && z > 0) {
      const double sum = (x + y) + z;
      out.v = p;
      out.squared = dot(p, p);
      out.index[0] = i, out.index[1] = j, out.index[2] = k;
      out.weight[0] = x / sum, out.weight[1] = y / sum, out.weight[2] = z / sum;
      out.count = 3;
      return out;
    }
    if (x <= 0) take(out, of_segment(w, j, k));
    if (y <= 0) take(out, of_segment(w, k, i));
    if (z <= 0) take(out, of_segment(w, i, j));
    return out;
  }
  take(out, of_segment(w, j, k));
  take(out, of_segment(w, k, i));
  take(out, of_segment(w, i, j));
  return out;
}

Nearest of_tetrahedron(const Vec3* w) {
  const Vec3 &a = w[0], &b = w[1], &c = w[2], &d = w[3];
  // Volumes of the origin with each face, and of the whole.
  const double va = dot(b, cross(c, d)), vb = -dot(a, cross(c, d)), vc = dot(a, cross(b, d)), vd = -dot(a, cross(b, c));
  const double whole = dot(b - a, cross(c - a, d - a));
  const double sign = whole > 0 ? 1 : -1;
  Nearest out;
  if (whole != 0 && va * sign > 0 && vb * sign > 0 && vc * sign > 0 && vd * sign > 0) {
    out.inside = true;
    return out;
  }
  if (whole == 0 || va * sign <= 0) take(out, of_triangle(w, 1, 2, 3));
  if (whole == 0 || vb * sign <= 0) take(out, of_triangle(w, 0, 2, 3));
  if (whole == 0 || vc * sign <= 0) take(out, of_triangle(w, 0, 1, 3));
  if (whole == 0 || vd * sign <= 0) take(out, of_triangle(w, 0, 1, 2));
  return out;
}

// Keeps the corners of the nearest simplex, in its order.
void keep(const Nearest& nearest, Gjk& g) {
  bool in_place = true;
  for (int i = 0; i < nearest.count; ++i) in_place &= nearest.index[i] == i;
  g.count = nearest.count;
  if (in_place) return;
  Vec3 w[3], wa[3], wb[3];
  for (int i = 0; i < nearest.count; ++i) {
    const int from = nearest.index[i];
    w[i] = g.w[from], wa[i] = g.wa[from], wb[i] = g.wb[from];
  }
  for (int i = 0; i < nearest.count; ++i) g.w[i] = w[i], g.wa[i] = wa[i], g.wb[i] = wb[i];
}

}  // namespace

Gjk calc_gjk(const Core& a, const Core& b, const Vec3& towards) {
  Gjk g;
  const Vec3 between = b.c - a.c;
  const double size = (a.bound + b.bound) + norm(between);
  const double touching = (kRelative * size) * (kRelative * size);
  g.wa[0] = calc_support(a, towards);
  g.wb[0] = calc_support(b, -towards);
  g.w[0] = g.wa[0] - g.wb[0];
  g.count = 1;
  Nearest nearest = of_point(g.w, 0);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Vec3 v = nearest.v;
    if (nearest.squared <= touching) {
      g.overlap = true;
      break;
    }
    const Vec3 sa = calc_support(a, -v), sb = calc_support(b, v), s = sa - sb;
    if (nearest.squared - dot(v, s) <= kRelative * size * std::sqrt(nearest.squared)) break;
    bool known = false;
    for (int i = 0; i < g.count; ++i) known |= g.w[i].x == s.x && g.w[i].y == s.y && g.w[i].z == s.z;
    if (known) break;
    g.w[g.count] = s, g.wa[g.count] = sa, g.wb[g.count] = sb;
    const int count = g.count + 1;
    const Nearest next = count == 2   ? of_segment(g.w, 0, 1)
                         : count == 3 ? of_triangle(g.w, 0, 1, 2)
                                      : of_tetrahedron(g.w);
    if (next.inside) {
      g.count = 4;
      g.overlap = true;
      return g;
    }
    if (!(next.squared < nearest.squared)) break;  // rounding
    keep(next, g);
    nearest = next;
  }
  g.a = g.b = {0, 0, 0};
  for (int i = 0; i < g.count; ++i) {
    g.a += nearest.weight[i] * g.wa[i];
    g.b += nearest.weight[i] * g.wb[i];
  }
  return g;
}

}  // namespace unlatch::geometry
