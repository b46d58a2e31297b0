#include "kernel/geometry/penetration.h"

#include <initializer_list>
#include <limits>

namespace unlatch::geometry {
namespace {

constexpr int kMostPoints = 112;
constexpr int kMostFaces = 2 * kMostPoints;
constexpr int kMostPolished = 16;
constexpr double kAlikeLast = 0.9998;  // 1°
constexpr double kAlike = 0.985;       // cosine: normals nearer than 10° lead to one minimum

struct Face {
  int i, j, k;  // counterclockwise from outside
  Vec3 n{0, 0, 0};
  double offset = 0;
};

// Expanding polytope of A − B.
class Polytope {
 public:
  Polytope(const Core& a, const Core& b, double size) : a_(a), b_(b), flat_(1e-10 * size) {}

  // A tetrahedron. False where A − B has no volume; then `across` is a direction in which it has no width.
  bool build(Vec3& across) {
    const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double widest = -1;
    for (const Vec3& e : axes) {
      const Vec3 p = support(e), q = support(-e);
      const double width = dot(e, p - q);
      if (width > widest) widest = width, points_[0] = p, points_[1] = q;
    }
    Vec3 line = points_[1] - points_[0];
    const double length = norm(line);
    if (length <= flat_) return across = {0, 0, 1}, false;
    line = (1.0 / length) * line;
    Vec3 u = calc_across(line);
    if (!add_farthest(2, u, cross(line, u))) return across = u, false;
    Vec3 n = cross(line, points_[2] - points_[0]);
    n = (1.0 / norm(n)) * n;
    if (!add_farthest(3, n, n)) return across = n, false;
    point_count_ = 4;
    const bool out = dot(n, points_[3] - points_[0]) > 0;  // 0, 1, 2 turns about n
    if (out) {
      add_face(0, 2, 1), add_face(0, 1, 3), add_face(1, 2, 3), add_face(2, 0, 3);
    } else {
      add_face(0, 1, 2), add_face(1, 0, 3), add_face(2, 1, 3), add_face(0, 2, 3);
    }
    return true;
  }

  // The face nearest to the origin, of equals the first.
  const Face& get_nearest() const {
    int best = 0;
    for (int f = 1; f < face_count_; ++f)
      if (faces_[f].offset < faces_[best].offset) best = f;
    return faces_[best];
  }

  int get_face_count() const { return face_count_; }
  const Face& get_face(int f) const { return faces_[f]; }

  // Adds the support point beyond a face. False if there is no room for it, or the face is a face of A − B.
  bool expand(const Face& face) {
    if (point_count_ == kMostPoints) return false;
    const Vec3 p = support(face.n);
    const double tolerance = 1e-13 * (flat_ * 1e10);
    if (dot(face.n, p) - face.offset <= tolerance) return false;
    points_[point_count_] = p;
    // Faces in front of which the point lies are removed, and the edges of the hole are connected with it.
    int edges[3 * kMostFaces][2];
    int edge_count = 0, kept = 0;
    for (int f = 0; f < face_count_; ++f) {
      const Face& g = faces_[f];
      if (dot(g.n, p) - g.offset > tolerance) {
        const int corners[3] = {g.i, g.j, g.k};
        for (int e = 0; e < 3; ++e) {
          const int from = corners[e], to = corners[(e + 1) % 3];
          bool shared = false;
          for (int k = 0; k < edge_count && !shared; ++k) {
            if (edges[k][0] == to && edges[k][1] == from) {
              --edge_count;
              edges[k][0] = edges[edge_count][0], edges[k][1] = edges[edge_count][1];
              shared = true;
            }
          }
          if (!shared) edges[edge_count][0] = from, edges[edge_count][1] = to, ++edge_count;
        }
      } else {
        faces_[kept++] = g;
      }
    }
    face_count_ = kept;
    for (int e = 0; e < edge_count; ++e) {
      if (face_count_ == kMostFaces) return false;
      add_face(edges[e][0], edges[e][1], point_count_);
    }
    ++point_count_;
    return face_count_ > 0;
  }

 private:
  Vec3 support(const Vec3& d) const { return calc_support(a_, d) - calc_support(b_, -d); }

  bool add_farthest(int at, const Vec3& u, const Vec3& v) {
    double best = flat_;
    bool found = false;
    for (const Vec3& d : {u, -u, v, -v}) {
      const Vec3 p = support(d);
      const double far = dot(d, p - points_[0]);
      if (far > best) best = far, points_[at] = p, found = true;
    }
    return found;
  }

  void add_face(int i, int j, int k) {
    Face face{i, j, k};
    Vec3 n = cross(points_[j] - points_[i], points_[k] - points_[i]);
    const double length = norm(n);
    if (length > 0) {
      face.n = (1.0 / length) * n;
      face.offset = dot(face.n, points_[i]);
    } else {
      face.offset = std::numeric_limits<double>::infinity();  // without area: never the nearest
    }
    faces_[face_count_++] = face;
  }

  const Core &a_, &b_;
  double flat_;
  Vec3 points_[kMostPoints];
  int point_count_ = 0;
  Face faces_[kMostFaces];
  int face_count_ = 0;
};

// Normal between the cores at half their size, which overlap less; if even those overlap, the line of the centres.
Vec3 calc_shrunk_normal(const Core& a, const Core& b) {
  Core small[2] = {a, b};
  bool scaled = true;
  for (Core& core : small) {
    scaled &= core.kind != Core::Kind::kPoints;
    core.h *= 0.5, core.r0 *= 0.5, core.r1 *= 0.5, core.length *= 0.5, core.bound *= 0.5;
    core.half = 0.5 * core.half;
  }
  if (scaled) {
    const Closest c = calc_closest(small[0], small[1]);
    if (c.apart) return c.n;
  }
  const Vec3 way = b.c - a.c;
  const double length = norm(way);
  return length > 0 ? (1.0 / length) * way : Vec3{0, 0, 1};
}

// A depth is better than the best one so far if it is less or, of equal depths, if its witnesses lie more nearly
// opposite each other; `gap`: how far across the normal they are apart, m. Where only the new witnesses lie opposite,
// depths count as equal up to the rounding of the normal: the other depth depends on the normal in first order.
bool is_better(double depth, double gap, const Depth& best, double size) {
  constexpr double kOpposite = 1e-9, kRounded = 1e-11, kSame = 1e-14;
  const bool only_new = gap <= kOpposite * size && best.gap > kOpposite * size;
  const double same = (only_new ? kRounded : kSame) * size;
  return depth < best.depth - same || (depth <= best.depth + same && gap < best.gap);
}

Vec3 get_axis(const Core& core, int i) { return i == 0 ? core.R.x : (i == 1 ? core.R.y : core.R.z); }
double get_half(const Core& core, int i) { return i == 0 ? core.half.x : (i == 1 ? core.half.y : core.half.z); }

// Depth of two boxes. A − B has 15 directions of faces: those of either box, and the products of an edge of each; its
// nearest face is across one of them. No other direction needs to be searched.
class BoxDepth {
 public:
  BoxDepth(const Core& a, const Core& b, double size) : a_(a), b_(b), size_(size), between_(b.c - a.c) {}

  Depth calc() {
    for (int i = 0; i < 3; ++i) try_direction(get_axis(a_, i), 0, {i, -1});
    for (int k = 0; k < 3; ++k) try_direction(get_axis(b_, k), 0, {-1, k});
    constexpr double kParallel = 1e-6,
                     kWorth = 1e-12;  // sine of edges that have no direction of their own; of the size
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const Vec3 across = cross(get_axis(a_, i), get_axis(b_, k));
        const double sine = norm(across);
        if (sine > kParallel) try_direction((1 / sine) * across, kWorth * size_, {i, k});
      }
    return find_witnesses();
  }

 private:
  // Edges or faces that lie across a direction: of A, of B, or −1.
  struct Feature {
    int of_a, of_b;
  };

  // `worth`: by how much the depth must be less than that so far, m.
  void try_direction(const Vec3& axis, double worth, Feature feature) {
    const Vec3 n = dot(axis, between_) < 0 ? -axis : axis;
    const double depth = (calc_reach(a_, n) + calc_reach(b_, n)) - dot(n, between_);
    if (!(depth < best_.depth - worth)) return;
    best_.n = n;
    best_.depth = depth;
    feature_ = feature;
  }

  static double calc_reach(const Core& box, const Vec3& n) {
    return (std::fabs(dot(box.R.x, n)) * box.half.x + std::fabs(dot(box.R.y, n)) * box.half.y) +
           std::fabs(dot(box.R.z, n)) * box.half.z;
  }

  // The corner that is farthest along d; in the middle of the edge along axis `but`. False if an edge lies across d.
  static bool find_corner(const Core& box, const Vec3& d, int but, Vec3& out) {
    constexpr double kAcross = 1e-8;  // rad
    out = box.c;
    for (int i = 0; i < 3; ++i) {
      const double along = dot(get_axis(box, i), d);
      if (i == but) continue;
      if (!(std::fabs(along) > kAcross)) return false;
      out += (along > 0 ? get_half(box, i) : -get_half(box, i)) * get_axis(box, i);
    }
    return true;
  }

  static bool is_within(const Core& box, const Vec3& point, int but) {
    const Vec3 at = to_local(box, point);
    const double over[3] = {std::fabs(at.x) - box.half.x, std::fabs(at.y) - box.half.y, std::fabs(at.z) - box.half.z};
    for (int i = 0; i < 3; ++i)
      if (i != but && over[i] > 0) return false;
    return true;
  }

  // A corner opposite a face, or two edges; in all other cases the local search from the direction.
  Depth find_witnesses() {
    const Vec3 n = best_.n, way = best_.depth * n;
    if (feature_.of_b < 0 && find_corner(b_, -n, -1, best_.b)) {
      best_.a = best_.b + way;
      if (is_within(a_, best_.a, feature_.of_a)) return best_;
    } else if (feature_.of_a < 0 && find_corner(a_, n, -1, best_.a)) {
      best_.b = best_.a - way;
      if (is_within(b_, best_.b, feature_.of_b)) return best_;
    } else if (feature_.of_a >= 0 && feature_.of_b >= 0 && find_corner(a_, n, feature_.of_a, best_.a) &&
               find_corner(b_, -n, feature_.of_b, best_.b)) {
      const Vec3 u = get_axis(a_, feature_.of_a), v = get_axis(b_, feature_.of_b), w = best_.b - best_.a;
      const double cosine = dot(u, v), along_v = (cosine * dot(w, u) - dot(w, v)) / (1 - cosine * cosine);
      const double along_u = dot(w, u) + along_v * cosine;
      if (std::fabs(along_u) <= get_half(a_, feature_.of_a) && std::fabs(along_v) <= get_half(b_, feature_.of_b)) {
        best_.a += along_u * u;
        best_.b += along_v * v;
        return best_;
      }
    }
    return calc_depth_near(a_, b_, n, size_);
  }

  const Core &a_, &b_;
  double size_;
  Vec3 between_;
  Depth best_{.depth = std::numeric_limits<double>::infinity()};
  Feature feature_{-1, -1};
};

}  // namespace

Depth calc_depth_near(const Core& a, const Core& b, const Vec3& start, double size) {
  constexpr int kMostIterations = 32;
  constexpr double kTurned = 4e-15, kLongest = 0.5;  // rad
  Depth best;
  best.depth = std::numeric_limits<double>::infinity();
  Vec3 n = start, plain = start;
  bool stepped = false;
  double last = best.depth;
  Core moved = b;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Vec3 sa = calc_support(a, n), sb = calc_support(b, -n);
    const double width = dot(n, sa - sb);  // upper bound of the depth
    const double s = (width > 0 ? width : 0.0) + 0.05 * size;
    moved.c = b.c + s * n;
    Closest c = calc_closest_from(a, moved, calc_projection(a, sb + s * n).p, size);
    if (c.apart && c.gap > 1e-13 * size) c = calc_closest(a, moved);
    if (!c.apart) break;  // possible by rounding alone
    const Vec3 back = c.b - s * n;
    const double depth = calc_extent(a, c.n) + calc_extent(b, -c.n);
    const Vec3 turned = n - dot(n, c.n) * c.n;  // from the resulting normal to the present one
    const double turn = norm(turned);
    if (is_better(depth, s * turn, best, size)) {
      best.a = c.a;
      best.b = back;
      best.n = c.n;
      best.depth = depth;
      best.gap = s * turn;
    }
    if (turn <= kTurned) break;
    if (stepped && depth > last + 1e-13 * size) {
      n = plain;  // the step has left the piece of the surface that it was computed for
      stepped = false;
      continue;
    }
    last = depth;
    // Newton: n' = K n near the minimum, K = s (R − depth + s)⁻¹ with the curvature R, hence n* = n' − s (R − depth)⁻¹
    // turned.
    const Curvature R = calc_curvature(a, moved, c);
    const double uu = R.uu - depth, vv = R.vv - depth, determinant = uu * vv - R.uv * R.uv;
    const double x = dot(turned, R.u), y = dot(turned, R.v);
    Vec3 step{0, 0, 0};
    if (uu > 0 && vv > 0 && determinant > 0) {
      const double du = s * ((vv * x - R.uv * y) / determinant), dv = s * ((uu * y - R.uv * x) / determinant);
      const double length = std::sqrt(du * du + dv * dv), k = length > kLongest ? kLongest / length : 1;
      step = -((k * du) * R.u + (k * dv) * R.v);
    } else {
      step = (-kLongest / turn) * turned;  // no minimum here: a long step
    }
    plain = c.n;
    n = c.n + step;
    n = (1.0 / norm(n)) * n;
    stepped = true;
  }
  return best;
}

Depth calc_depth(const Core& a, const Core& b) {
  const double size = calc_pair_size(a, b);
  if (a.kind == Core::Kind::kBox && b.kind == Core::Kind::kBox) return BoxDepth(a, b, size).calc();
  Polytope polytope(a, b, size);
  Depth best;
  Vec3 across{0, 0, 1};
  if (!polytope.build(across)) {
    // Two segments that cross, or a point in another core without volume: they touch, and part across both.
    const Closest c = calc_closest(a, b);
    best.a = c.a, best.b = c.b, best.n = across;
    return best;
  }
  best = calc_depth_near(a, b, calc_shrunk_normal(a, b), size);
  const double tolerance = (is_polytope(a) && is_polytope(b) ? 1e-12 : 1e-5) * size;
  Vec3 tried[2 * kMostPolished];
  int tried_count = 0;
  const auto polish = [&](const Face& face, double alike) {
    for (int i = 0; i < tried_count; ++i)
      if (dot(tried[i], face.n) > alike) return;
    if (tried_count + 2 > 2 * kMostPolished) return;
    const Depth polished = calc_depth_near(a, b, face.n, size);
    tried[tried_count++] = face.n;
    tried[tried_count++] = polished.n;
    if (is_better(polished.depth, polished.gap, best, size)) best = polished;
  };
  bool room = true;
  for (int step = 0; room && step < kMostPoints; ++step) {
    const Face face = polytope.get_nearest();
    // The depth lies between the offset and the best; the tolerance is what flat faces miss of a curved surface.
    if (best.depth - face.offset <= tolerance) return best;
    polish(face, kAlike);
    room = polytope.expand(face);
  }
  // The expansion has ended: at a face of A − B, or for lack of room. The other faces that may have a lesser depth:
  for (int f = 0; f < polytope.get_face_count(); ++f) {
    const Face& face = polytope.get_face(f);
    if (face.offset < best.depth - tolerance &&
        calc_extent(a, face.n) + calc_extent(b, -face.n) < best.depth + 0.03 * size)
      polish(face, kAlikeLast);
  }
  return best;
}

}  // namespace unlatch::geometry
