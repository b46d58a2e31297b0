#include "kernel/geometry/closest.h"

#include "kernel/geometry/gjk.h"

namespace unlatch::geometry {
namespace {

constexpr int kMostIterations = 24;
constexpr double kRounding = 2e-16;   // of the pair's size
constexpr double kLevel = 1e-12;      // relative change of the squared distance that counts as none
constexpr double kCertified = 1e-13;  // of the pair's size: up to this gap no second method is tried

double calc_gap(const Core& a, const Core& b, const Closest& c) {
  return c.distance + (calc_extent(a, c.n) + calc_extent(b, -c.n));
}

// δ of (I − J_A J_B) δ = r. δ = r + U_A y, and y solves (I − Λ_A C Λ_B Cᵀ) y = Λ_A C Λ_B U_Bᵀ r with C = U_Aᵀ U_B.
Vec3 calc_newton_step(const Tangent& A, const Tangent& B, const Vec3& r) {
  const double c11 = dot(A.u1, B.u1), c12 = dot(A.u1, B.u2), c21 = dot(A.u2, B.u1), c22 = dot(A.u2, B.u2);
  // K = Λ_A C Λ_B
  const double k11 = A.l1 * c11 * B.l1, k12 = A.l1 * c12 * B.l2, k21 = A.l2 * c21 * B.l1, k22 = A.l2 * c22 * B.l2;
  const double m11 = 1 - (k11 * c11 + k12 * c12), m12 = -(k11 * c21 + k12 * c22);
  const double m21 = -(k21 * c11 + k22 * c12), m22 = 1 - (k21 * c21 + k22 * c22);
  const double r1 = dot(B.u1, r), r2 = dot(B.u2, r);
  const double f1 = k11 * r1 + k12 * r2, f2 = k21 * r1 + k22 * r2;
  const double determinant = m11 * m22 - m12 * m21;
  constexpr double kSingular = 1e-15;  // both are flat in one direction: all points along it are equally near
  if (!(std::fabs(determinant) > kSingular)) return r;
  const double y1 = (f1 * m22 - m12 * f2) / determinant, y2 = (m11 * f2 - f1 * m21) / determinant;
  return r + (y1 * A.u1 + y2 * A.u2);
}

// Way of two points that counts as none, squared.
double calc_touching(double size) { return (kRounding * size) * (kRounding * size); }

// Distance, direction and certificate of the nearest points `at`; `apart`: neither is inside of the other core.
Closest complete(const Core& a, const Core& b, const Closest& at, bool apart, double size) {
  Closest out = at;
  const Vec3 d = at.b - at.a;
  const double squared = dot(d, d);
  if (!apart || squared <= calc_touching(size)) return out;
  out.apart = true;
  out.distance = std::sqrt(squared);
  out.n = (1.0 / out.distance) * d;
  out.gap = calc_gap(a, b, out);
  return out;
}

// Where one of the cores is a point, one projection is all.
Closest calc_closest_of_point(const Core& a, const Core& b, double size) {
  Closest at;
  const bool of_a = a.kind == Core::Kind::kPoint;
  const Projection on = of_a ? calc_projection(b, a.c) : calc_projection(a, b.c);
  at.a = of_a ? a.c : (on.inside ? b.c : on.p);
  at.b = of_a ? on.p : b.c;
  return complete(a, b, at, !on.inside, size);
}

}  // namespace

double calc_pair_size(const Core& a, const Core& b) { return (a.bound + b.bound) + norm(b.c - a.c); }

Closest calc_closest_from(const Core& a, const Core& b, const Vec3& start, double size) {
  // y is the point that is projected onto A: the latest of B, or Newton's estimate of the next in B's tangent plane.
  Closest best;
  Projection on_a, on_b;
  on_a.p = start;
  on_b = calc_projection(b, start);
  best.a = start;
  best.b = on_b.p;
  Vec3 y = best.b, d = best.b - best.a;
  double squared = dot(d, d);
  const double touching = calc_touching(size);
  // Near the end a step changes the residual, but no longer the distance, in which it is of second order.
  bool level = false, newton = false, apart = !on_b.inside;
  double last = 0;
  for (int iteration = 0; apart && squared > touching && iteration < kMostIterations; ++iteration) {
    on_a = calc_projection(a, y);
    if (on_a.inside && !newton) {
      best.a = best.b;
      return best;
    }
    on_b = calc_projection(b, on_a.p);
    d = on_b.p - on_a.p;
    const double next = dot(d, d), limit = squared * (1 + kLevel);
    if (newton && (on_a.inside || on_b.inside || !(next < limit))) {
      y = best.b;  // the distance grew: alternating projections instead, with which it never does
      newton = false;
      continue;
    }
    if (!(next < limit)) break;
    const Vec3 r = on_b.p - y;
    const double residual = dot(r, r);
    if (level && residual > 0.25 * last) break;
    level = next > squared * (1 - kLevel);
    last = residual;
    best.a = on_a.p;
    best.b = on_b.p;
    squared = next;
    apart = !on_b.inside;
    if (residual <= touching) break;
    y = y + calc_newton_step(on_b.J, on_a.J, r);
    newton = true;
  }
  return complete(a, b, best, apart, size);
}

Closest calc_closest(const Core& a, const Core& b) {
  const double size = calc_pair_size(a, b);
  Closest first;
  const bool polytopes =
      is_polytope(a) && is_polytope(b) && a.kind != Core::Kind::kPoint && b.kind != Core::Kind::kPoint;
  if (!polytopes) {
    const bool point = a.kind == Core::Kind::kPoint || b.kind == Core::Kind::kPoint;
    first = point ? calc_closest_of_point(a, b, size) : calc_closest_from(a, b, calc_projection(a, b.c).p, size);
    if (!first.apart || first.gap <= kCertified * size) return first;
  }
  const Gjk g = calc_gjk(a, b, b.c - a.c);
  Closest second;
  second.a = g.a, second.b = g.b;
  const Vec3 d = g.b - g.a;
  second.distance = norm(d);
  second.apart = !g.overlap && second.distance > kRounding * size;
  if (second.apart) {
    second.n = (1.0 / second.distance) * d;
    second.gap = calc_gap(a, b, second);
    if (!polytopes && second.gap > kCertified * size) second = calc_closest_from(a, b, calc_projection(a, g.b).p, size);
  }
  return polytopes || !second.apart || second.gap < first.gap ? second : first;
}

bool find_closest_to_point(const Core& a, const Vec3& b, Closest& out) {
  const double size = a.bound + norm(b - a.c);
  const Projection on = calc_projection(a, b);
  const Vec3 d = b - on.p;
  const double squared = dot(d, d);
  if (on.inside || squared <= calc_touching(size)) return false;
  const double distance = std::sqrt(squared);
  const Vec3 n = (1.0 / distance) * d;
  const double gap = distance + (calc_extent(a, n) + dot(-n, b));
  out = {on.p, b, n, distance, gap, true};
  return gap <= kCertified * size;
}

Curvature calc_curvature(const Core& a, const Core& b, const Closest& at) {
  Curvature out;
  out.u = calc_across(at.n);
  out.v = cross(at.n, out.u);
  const auto add = [&](const Tangent& J) {
    const auto add_direction = [&](const Vec3& t, double l) {
      if (!(l > 0)) return;
      constexpr double kFlat = 1e-9;
      const double radius = at.distance * l / (1 - l > kFlat ? 1 - l : kFlat);
      const double x = dot(t, out.u), y = dot(t, out.v);
      out.uu += radius * x * x, out.uv += radius * x * y, out.vv += radius * y * y;
    };
    add_direction(J.u1, J.l1);
    add_direction(J.u2, J.l2);
  };
  add(calc_projection(a, at.b).J);
  add(calc_projection(b, at.a).J);
  return out;
}

}  // namespace unlatch::geometry
