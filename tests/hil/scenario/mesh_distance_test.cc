// Distances of triangle meshes: against closed forms, the kernel's shapes, and all pairs of triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "hil/scenario/shapes/clearance.h"
#include "hil/scenario/shapes/mesh_tree.h"
#include "tests/hil/scenario/mesh_support.h"
#include "tests/support/random.h"

namespace unlatch::test::mesh_distance_test {
namespace {

using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using Kind = geometry::ShapeKind;
using MeshPointer = std::shared_ptr<const hil::TriangleMesh>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kSingle = 1e-6;  // m: single precision of coordinates of some metres
constexpr double kExact = 1e-9;   // m: the kernel's error for shapes of about a metre
constexpr double kPi = 3.14159265358979323846;

MeshPointer build_mesh(const Facets& facets, const hil::MeshPlace& place = {}) {
  return std::make_shared<const hil::TriangleMesh>(place, hil::read_mesh(write_binary_stl(facets), "part.stl"));
}

Vec3 draw_vector(Random& random, double reach) {
  const double x = random.uniform(-reach, reach), y = random.uniform(-reach, reach);
  return {x, y, random.uniform(-reach, reach)};
}

Placement draw_placement(Random& random, double reach) {
  Quat q{1, 0, 0, 0};
  do {
    const Vec3 v = draw_vector(random, 1);
    q = {random.uniform(-1, 1), v.x, v.y, v.z};
  } while (norm_squared(q) < 0.1);
  return {draw_vector(random, reach), rotation_matrix(normalized(q))};
}

geometry::ShapeGroup build_group(const Shape& shape) { return geometry::build_group("", {&shape, 1}); }

double calc(const MeshPointer& mesh, const Placement& at, const Shape& shape, const Placement& at_shape) {
  return mesh->get_tree().calc_distance(at, build_group(shape), at_shape, kInfinite).distance;
}

double calc(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b) {
  return geometry::calc_distance(build_group(a), at_a, build_group(b), at_b).least.distance;
}

// Lists one shape of each convex kind, some decimetres large, a wall and a plane.
std::vector<Shape> list_shapes() {
  return {{.kind = Kind::kSphere, .from = {0.1, 0, 0}, .radius = 0.3},
          {.kind = Kind::kCapsule, .from = {-0.4, 0, 0}, .to = {0.3, 0.2, 0}, .radius = 0.1},
          {.kind = Kind::kCylinder, .from = {0, 0, -0.5}, .to = {0, 0.1, 0.4}, .radius = 0.25},
          {.kind = Kind::kCone, .from = {0, 0, 0}, .to = {0.6, 0, 0}, .radius = 0.3},
          {.kind = Kind::kFrustum, .from = {0, 0, 0}, .to = {0, 0.5, 0}, .radius = 0.3, .end_radius = 0.1},
          {.kind = Kind::kBox, .from = {0, 0, 0.1}, .size = {0.3, 0.5, 0.8}},
          {.kind = Kind::kHull, .points = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}, {0.4, 0.4, 0.4}}},
          {.kind = Kind::kHollow, .from = {0, 0, -0.3}, .to = {0, 0, 0.3}, .profile = {{0, 0.2}, {0.6, 0.4}}},
          {.kind = Kind::kHalfSpace, .from = {0, 0, -0.2}, .normal = {0.1, 0, 1}}};
}

TEST(MeshDistance, OfABoxIsThatOfTheKernelsBox) {
  constexpr std::uint64_t kSeed = 1;
  Random random(kSeed);
  const Vec3 half{0.5, 0.25, 0.75};  // exact in single precision
  const MeshPointer mesh = build_mesh(build_box_facets(half));
  const Shape box{.kind = Kind::kBox, .size = 2.0 * half};
  for (const Shape& shape : list_shapes()) {
    int apart = 0;
    for (int i = 0; i < 300; ++i) {
      const Placement at = draw_placement(random, 1.5), at_shape = draw_placement(random, 1.5);
      const double expected = calc(box, at, shape, at_shape), found = calc(mesh, at, shape, at_shape);
      if (expected > 0) {
        ++apart;
        ASSERT_NEAR(found, expected, kExact)
            << "seed " << kSeed << " kind " << static_cast<int>(shape.kind) << " " << i;
      } else {
        ASSERT_GE(found, 0);  // 0 where it crosses a face; else it lies within the box
      }
    }
    EXPECT_GT(apart, 50) << static_cast<int>(shape.kind);
  }
}

// Corners lie on the solid, facets inside it: the mesh is farther away, by no more than their sagitta.
TEST(MeshDistance, OfRoundSolidsErrsByNoMoreThanTheFacets) {
  constexpr std::uint64_t kSeed = 2;
  constexpr int kAround = 64;
  constexpr double kRadius = 0.6;
  Random random(kSeed);
  const double chord = 1 - std::cos(kPi / kAround);  // sagitta of one arc, of a radius of 1; of a sphere's facet two
  struct Case {
    Facets facets;
    Shape solid;
    double sagitta;
  };
  const Case cases[] = {
      {build_sphere_facets(kRadius, kAround), {.kind = Kind::kSphere, .radius = kRadius}, 2 * chord * kRadius},
      {build_cylinder_facets(kRadius, 0.8, kAround),
       {.kind = Kind::kCylinder, .from = {0, 0, -0.8}, .to = {0, 0, 0.8}, .radius = kRadius},
       chord * kRadius}};
  for (const Case& c : cases) {
    const MeshPointer mesh = build_mesh(c.facets);
    double largest = 0;
    for (const Shape& shape : list_shapes())
      for (int i = 0; i < 60; ++i) {
        const Placement at = draw_placement(random, 1.5), at_shape = draw_placement(random, 1.5);
        const double expected = calc(c.solid, at, shape, at_shape), found = calc(mesh, at, shape, at_shape);
        if (!(expected > 0)) continue;
        ASSERT_GE(found, expected - kSingle) << "seed " << kSeed << " " << i;
        ASSERT_LE(found, expected + c.sagitta + kSingle) << "seed " << kSeed << " " << i;
        largest = std::max(largest, found - expected);
      }
    EXPECT_GT(largest, 0.1 * c.sagitta);
  }
}

TEST(MeshDistance, FromWithinIsThatToTheWallAndCrossingIsZero) {
  const MeshPointer mesh = build_mesh(build_box_facets({1, 1, 1}));
  const Shape ball{.kind = Kind::kSphere, .radius = 0.25};
  const auto at = [](double x) { return Placement{{x, 0, 0}, kIdentity3}; };
  EXPECT_NEAR(calc(mesh, {}, ball, at(0.5)), 0.25, kExact);
  EXPECT_NEAR(calc(mesh, {}, ball, at(1.5)), 0.25, kExact);
  EXPECT_EQ(calc(mesh, {}, ball, at(0.9)), 0);
  const MeshPointer small = build_mesh(build_box_facets({0.25, 0.25, 0.25}));
  const auto calc_two = [&](double x) {
    return mesh->get_tree().calc_distance({}, small->get_tree(), at(x), kInfinite).distance;
  };
  EXPECT_NEAR(calc_two(0.5), 0.25, kExact);
  EXPECT_NEAR(calc_two(1.5), 0.25, kExact);
  EXPECT_EQ(calc_two(0.9), 0);
}

// --- All pairs of triangles -----------------------------------------------------------------------------------------

struct Triangle {
  Vec3 p[3];
};

std::vector<Triangle> place(const hil::TriangleMesh& mesh, const Placement& at) {
  std::vector<Triangle> out;
  for (const auto& corners : mesh.get_triangles()) {
    Triangle& t = out.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) t.p[k] = at.p_WB + at.R_WB * mesh.get_vertices()[corners[k]];
  }
  return out;
}

double clamp01(double x) { return std::clamp(x, 0.0, 1.0); }

double calc_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = d - c, w = a - c;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  const double det = uu * vv - uv * uv;
  double least = kInfinite;
  const auto look = [&](double s) {
    const double t = clamp01((uv * s + vw) / vv), back = clamp01((uv * t - uw) / uu);
    least = std::min({least, norm(w + s * u - t * v), norm(w + back * u - t * v)});
  };
  look(0), look(1);
  if (det > 0) look(clamp01((uv * vw - vv * uw) / det));
  return least;
}

// Distance from a point to a triangle's plane, if the point is above the triangle; else infinite, as the edges are
// searched.
double calc_above(const Vec3& p, const Triangle& t) {
  const Vec3 n = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
  for (int k = 0; k < 3; ++k)
    if (dot(cross(t.p[(k + 1) % 3] - t.p[k], p - t.p[k]), n) < 0) return kInfinite;
  return std::abs(dot(n, p - t.p[0])) / norm(n);
}

bool pierces(const Vec3& a, const Vec3& b, const Triangle& t) {
  const Vec3 n = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
  const double da = dot(n, a - t.p[0]), db = dot(n, b - t.p[0]);
  if (da * db > 0 || da == db) return false;
  return calc_above(a + (da / (da - db)) * (b - a), t) < kInfinite;
}

double calc_triangles(const Triangle& a, const Triangle& b) {
  double least = kInfinite;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a0 = a.p[i], &a1 = a.p[(i + 1) % 3], &b0 = b.p[i], &b1 = b.p[(i + 1) % 3];
    if (pierces(a0, a1, b) || pierces(b0, b1, a)) return 0;
    least = std::min({least, calc_above(a0, b), calc_above(b0, a)});
    for (int k = 0; k < 3; ++k) least = std::min(least, calc_segments(a0, a1, b.p[k], b.p[(k + 1) % 3]));
  }
  return least;
}

// Builds irregular facets: each corner of a sphere's is moved in or out.
Facets build_rough_facets(Random& random, int around) {
  Facets facets = build_sphere_facets(0.5, around);
  for (Facet& f : facets)
    for (Vec3* p : {&f.a, &f.b, &f.c}) *p = random.uniform(0.5, 1.5) * *p;
  return facets;
}

TEST(MeshDistance, OfTwoMeshesIsTheLeastOfAllPairsOfTriangles) {
  constexpr std::uint64_t kSeed = 3;
  Random random(kSeed);
  int crossing = 0, apart = 0;
  for (int round = 0; round < 4; ++round) {
    const MeshPointer a = build_mesh(build_rough_facets(random, 12)), b = build_mesh(build_rough_facets(random, 10));
    for (int i = 0; i < 40; ++i) {
      const Placement at_a = draw_placement(random, 0.8), at_b = draw_placement(random, 0.8);
      double expected = kInfinite;
      const std::vector<Triangle> of_b = place(*b, at_b);
      for (const Triangle& t : place(*a, at_a))
        for (const Triangle& u : of_b) expected = std::min(expected, calc_triangles(t, u));
      const Distance found = a->get_tree().calc_distance(at_a, b->get_tree(), at_b, kInfinite);
      ASSERT_NEAR(found.distance, expected, kExact) << "seed " << kSeed << " " << round << " " << i;
      ++(expected > 0 ? apart : crossing);
      if (!(expected > 0)) continue;
      ASSERT_NEAR(norm(found.on_b - found.on_a), expected, kExact);
      // Each witness point lies on its mesh.
      for (const auto& [witness, mesh, at] : {std::tuple(found.on_a, a, at_a), std::tuple(found.on_b, b, at_b)}) {
        double off = kInfinite;
        for (const Triangle& t : place(*mesh, at))
          for (int k = 0; k < 3; ++k)
            off = std::min({off, calc_above(witness, t),
                            calc_segments(witness, witness + Vec3{1e-12, 0, 0}, t.p[k], t.p[(k + 1) % 3])});
        ASSERT_LT(off, kExact);
      }
    }
  }
  EXPECT_GT(apart, 30);
  EXPECT_GT(crossing, 10);
}

// The walk over boxes misses no nearest triangle.
TEST(MeshDistance, OfAShapeIsTheLeastOfAllTriangles) {
  constexpr std::uint64_t kSeed = 4;
  Random random(kSeed);
  const MeshPointer mesh = build_mesh(build_rough_facets(random, 16));
  for (const Shape& shape : list_shapes()) {
    const geometry::ShapeGroup other = build_group(shape);
    for (int i = 0; i < 25; ++i) {
      const Placement at = draw_placement(random, 1), at_shape = draw_placement(random, 1);
      double expected = kInfinite;
      for (const Triangle& t : place(*mesh, at)) {
        const Shape flat{.kind = Kind::kHull, .points = {t.p[0], t.p[1], t.p[2]}};
        expected = std::min(expected, geometry::calc_distance(build_group(flat), {}, other, at_shape).least.distance);
      }
      const Distance found = mesh->get_tree().calc_distance(at, other, at_shape, kInfinite);
      ASSERT_NEAR(found.distance, std::max(expected, 0.0), kExact)
          << "seed " << kSeed << " kind " << static_cast<int>(shape.kind) << " " << i;
      if (expected > 0) {
        ASSERT_NEAR(norm(found.on_b - found.on_a), expected, kExact);
      }
      // A distance left out because of a limit is not smaller than the limit.
      const double limited = mesh->get_tree().calc_distance(at, other, at_shape, found.distance).distance;
      ASSERT_EQ(limited, kInfinite);
    }
  }
}

// Checks the distance from a sphere by a separate formula.
TEST(MeshDistance, OfASphereIsThatOfItsCentreToTheTriangles) {
  constexpr std::uint64_t kSeed = 5;
  Random random(kSeed);
  const MeshPointer mesh = build_mesh(build_rough_facets(random, 16));
  const Shape ball{.kind = Kind::kSphere, .radius = 0.1};
  for (int i = 0; i < 200; ++i) {
    const Vec3 centre = draw_vector(random, 1.5);
    double expected = kInfinite;
    for (const Triangle& t : place(*mesh, {}))
      for (int k = 0; k < 3; ++k)
        expected = std::min({expected, calc_above(centre, t),
                             calc_segments(centre, centre + Vec3{1e-12, 0, 0}, t.p[k], t.p[(k + 1) % 3])});
    ASSERT_NEAR(calc(mesh, {}, ball, {centre, kIdentity3}), std::max(0.0, expected - 0.1), kExact)
        << "seed " << kSeed << " " << i;
  }
}

// --- Watched pairs --------------------------------------------------------------------------------------------------

hil::ClearanceMonitor watch(const std::vector<std::vector<hil::BodyShape>>& shapes,
                            std::vector<std::pair<int, int>> except = {}) {
  hil::ClearancePair pair{.a = {0, "a", {}}, .b = {1, "b", {}}, .except = std::move(except)};
  for (auto* set : {&pair.a, &pair.b}) {
    set->shapes.resize(shapes[static_cast<std::size_t>(set->body)].size());
    std::iota(set->shapes.begin(), set->shapes.end(), 0);
  }
  return hil::ClearanceMonitor({pair}, shapes);
}

TEST(MeshDistance, OfWatchedPairsIsTheLeastOfMeshesAndShapesAndDistinguished) {
  const MeshPointer box =
      build_mesh(build_box_facets({1, 1, 1}), {.file = "box.stl", .scale = 0.5, .origin = {0, 0, 2}});
  const hil::BodyShape mesh{.name = "mesh", .group = "", .shape = {}, .mesh = box};
  const hil::BodyShape ball{.name = "ball", .group = "", .shape = {.kind = Kind::kSphere, .radius = 0.5}};
  const auto far_b = [](const Vec3& p) { return Placement{p, kIdentity3}; };

  hil::ClearanceMonitor both = watch({{mesh, ball}, {ball}});
  EXPECT_EQ(both.get()[0].method, hil::DistanceMethod::kMesh);
  EXPECT_STREQ(hil::get_method_name(both.get()[0].method), "mesh (triangles)");
  const hil::PairDistance to_mesh = both.calc(0, {}, far_b({0, 0, 4}));
  EXPECT_NEAR(to_mesh.least.distance, 1, kExact);  // 4 − 0.5 − 2.5
  EXPECT_EQ(to_mesh.shape_a, 0);
  EXPECT_NEAR(to_mesh.least.on_a.z, 2.5, kExact);
  EXPECT_NEAR(to_mesh.least.on_b.z, 3.5, kExact);
  EXPECT_NEAR(to_mesh.least.normal.z, 1, kExact);
  const hil::PairDistance to_ball = both.calc(0, {}, far_b({0, 0.75, 0}));
  EXPECT_NEAR(to_ball.least.distance, -0.25, kExact);  // of the kernel's shapes, with its depth
  EXPECT_EQ(to_ball.shape_a, 1);
  EXPECT_EQ(both.calc(0, {}, far_b({0, 0, 2.6})).least.distance, 0);

  hil::ClearanceMonitor other_way = watch({{ball}, {mesh}});
  const hil::PairDistance mirrored = other_way.calc(0, far_b({0, 0, 4}), {});
  EXPECT_NEAR(mirrored.least.on_a.z, 3.5, kExact);
  EXPECT_NEAR(mirrored.least.normal.z, -1, kExact);

  hil::ClearanceMonitor without = watch({{mesh, ball}, {ball}}, {{0, 0}});
  EXPECT_EQ(without.get()[0].method, hil::DistanceMethod::kExact);
  EXPECT_NEAR(without.calc(0, {}, far_b({0, 0, 4})).least.distance, 3, kExact);
  const hil::ClearanceMonitor meshes = watch({{mesh}, {mesh}});
  EXPECT_NEAR(meshes.get_reach(0).bound, 0.5 * std::sqrt(3.0), kExact);
}

}  // namespace
}  // namespace unlatch::test::mesh_distance_test
