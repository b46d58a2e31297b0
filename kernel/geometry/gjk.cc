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

// Each try replaces `best` by the nearest point to the origin of a corner, edge, face or tetrahedron if that is nearer.
bool is_nearer(const Nearest& best, double squared) { return best.count == 0 || squared < best.squared; }

void try_point(const Vec3* w, int i, Nearest& best) {
  const double squared = dot(w[i], w[i]);
  if (!is_nearer(best, squared)) return;
  best.v = w[i];
  best.squared = squared;
  best.index[0] = i;
  best.weight[0] = 1;
  best.count = 1;
}

void try_segment(const Vec3* w, int i, int j, Nearest& best) {
  const Vec3 e = w[j] - w[i];
  const double length = dot(e, e), t = -dot(w[i], e);
  if (!(t > 0)) return try_point(w, i, best);
  if (!(t < length)) return try_point(w, j, best);
  const double s = t / length;
  const Vec3 v = w[i] + s * e;
  const double squared = dot(v, v);
  if (!is_nearer(best, squared)) return;
  best.v = v;
  best.squared = squared;
  best.index[0] = i, best.index[1] = j;
  best.weight[0] = 1 - s, best.weight[1] = s;
  best.count = 2;
}

void try_triangle(const Vec3* w, int i, int j, int k, Nearest& best) {
  const Vec3 a = w[i], b = w[j], c = w[k];
  const Vec3 n = cross(b - a, c - a);
  const double area = dot(n, n);
  double x = 0, y = 0, z = 0;  // without an area all edges are tried
  if (area > 0) {
    const Vec3 p = (dot(a, n) / area) * n;
    const Vec3 pa = a - p, pb = b - p, pc = c - p;
    x = dot(cross(pb, pc), n), y = dot(cross(pc, pa), n), z = dot(cross(pa, pb), n);
    if (x > 0 && y > 0 && z > 0) {
      const double squared = dot(p, p);
      if (!is_nearer(best, squared)) return;
      const double sum = (x + y) + z;
      best.v = p;
      best.squared = squared;
      best.index[0] = i, best.index[1] = j, best.index[2] = k;
      best.weight[0] = x / sum, best.weight[1] = y / sum, best.weight[2] = z / sum;
      best.count = 3;
      return;
    }
  }
  if (x <= 0) try_segment(w, j, k, best);
  if (y <= 0) try_segment(w, k, i, best);
  if (z <= 0) try_segment(w, i, j, best);
}

void try_tetrahedron(const Vec3* w, Nearest& best) {
  const Vec3 &a = w[0], &b = w[1], &c = w[2], &d = w[3];
  // Volumes of the origin with each face, and of the whole.
  const double va = dot(b, cross(c, d)), vb = -dot(a, cross(c, d)), vc = dot(a, cross(b, d)), vd = -dot(a, cross(b, c));
  const double whole = dot(b - a, cross(c - a, d - a));
  const double sign = whole > 0 ? 1 : -1;
  if (whole != 0 && va * sign > 0 && vb * sign > 0 && vc * sign > 0 && vd * sign > 0) {
    best.inside = true;
    return;
  }
  if (whole == 0 || va * sign <= 0) try_triangle(w, 1, 2, 3, best);
  if (whole == 0 || vb * sign <= 0) try_triangle(w, 0, 2, 3, best);
  if (whole == 0 || vc * sign <= 0) try_triangle(w, 0, 1, 3, best);
  if (whole == 0 || vd * sign <= 0) try_triangle(w, 0, 1, 2, best);
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

// Support points of a core, and of a segment, whose ends are computed once.
struct CoreSupport {
  const Core& core;
  Vec3 operator()(const Vec3& d) const { return calc_support(core, d); }
};
struct SegmentSupport {
  Vec3 axis, low, high;
  explicit SegmentSupport(const Core& core)
      : axis(core.R.z), low(core.c + -core.h * core.R.z), high(core.c + core.h * core.R.z) {}
  Vec3 operator()(const Vec3& d) const { return dot(axis, d) >= 0 ? high : low; }
};

template <class Support>
Gjk find_nearest(const Core& a, const Core& b, const Vec3& towards) {
  const Support of_a{a}, of_b{b};
  Gjk g;
  const Vec3 between = b.c - a.c;
  const double size = (a.bound + b.bound) + norm(between);
  const double touching = (kRelative * size) * (kRelative * size);
  g.wa[0] = of_a(towards);
  g.wb[0] = of_b(-towards);
  g.w[0] = g.wa[0] - g.wb[0];
  g.count = 1;
  Nearest found[2];  // the latest, and the next try
  int latest = 0;
  try_point(g.w, 0, found[0]);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Nearest& nearest = found[latest];
    const Vec3 v = nearest.v;
    if (nearest.squared <= touching) {
      g.overlap = true;
      break;
    }
    const Vec3 sa = of_a(-v), sb = of_b(v), s = sa - sb;
    if (nearest.squared - dot(v, s) <= kRelative * size * std::sqrt(nearest.squared)) break;
    bool known = false;
    for (int i = 0; i < g.count; ++i) known |= g.w[i].x == s.x && g.w[i].y == s.y && g.w[i].z == s.z;
    if (known) break;
    g.w[g.count] = s, g.wa[g.count] = sa, g.wb[g.count] = sb;
    const int count = g.count + 1;
    Nearest& next = found[1 - latest];
    next.count = 0;
    if (count == 2)
      try_segment(g.w, 0, 1, next);
    else if (count == 3)
      try_triangle(g.w, 0, 1, 2, next);
    else
      try_tetrahedron(g.w, next);
    if (next.inside) {
      g.count = 4;
      g.overlap = true;
      return g;
    }
    if (!(next.squared < nearest.squared)) break;  // rounding
    keep(next, g);
    latest = 1 - latest;
  }
  g.a = g.b = {0, 0, 0};
  for (int i = 0; i < g.count; ++i) {
    g.a += found[latest].weight[i] * g.wa[i];
    g.b += found[latest].weight[i] * g.wb[i];
  }
  return g;
}

}  // namespace

Gjk calc_gjk(const Core& a, const Core& b, const Vec3& towards) {
  const bool segments = a.kind == Core::Kind::kSegment && b.kind == Core::Kind::kSegment;
  return segments ? find_nearest<SegmentSupport>(a, b, towards) : find_nearest<CoreSupport>(a, b, towards);
}

}  // namespace unlatch::geometry
