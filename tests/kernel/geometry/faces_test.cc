// Faces that lie on each other: their common region by sums over strips and samples of its lines, in every pairing;
// half walls that stand, lie and lean on a plane; and pairs of shapes that differ in one number alone.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "kernel/geometry/distance.h"
#include "tests/kernel/geometry/solids.h"

namespace unlatch::test::faces_test {
namespace {

using geometry::calc_distance;
using geometry::compile_shape;
using geometry::CompiledShape;
using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;
using std::numbers::pi;

constexpr double kReach = 3;      // m: every face lies within −3 … 3
constexpr int kStrips = 30000;    // of 0.2 mm
constexpr double kOfSums = 2e-5;  // m: error of the sums at the ends of discs, some (strip)^1.5
constexpr double kGap = 0.5;      // m between the two faces

struct Point {
  double x, y;
};

// A face in the plane z = 0 of a solid below or above it.
struct Face {
  Shape solid;
  std::vector<Point> corners;  // convex, counterclockwise; none: a disc
  Point centre{0, 0};
  double radius = 0;
  bool holds(double x, double y) const {
    if (corners.empty()) return std::hypot(x - centre.x, y - centre.y) <= radius;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &p = corners[i], &q = corners[(i + 1) % corners.size()];
      if ((q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x) < 0) return false;
    }
    return true;
  }
  // [low, high] of y at x; low > high: nothing there.
  std::pair<double, double> get_range(double x) const {
    if (corners.empty()) {
      const double square = radius * radius - (x - centre.x) * (x - centre.x);
      if (square <= 0) return {1, -1};
      return {centre.y - std::sqrt(square), centre.y + std::sqrt(square)};
    }
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Point &p = corners[i], &q = corners[(i + 1) % corners.size()];
      if ((p.x - x) * (q.x - x) > 0 || p.x == q.x) continue;
      const double y = p.y + (q.y - p.y) * (x - p.x) / (q.x - p.x);
      low = std::min(low, y), high = std::max(high, y);
    }
    return {low, high};
  }
};

// `up`: 1 for a solid above its face, −1 for one below; `z`: of the face.
Face draw_face(Random& random, int kind, double up, double z) {
  Face face;
  const Point c{random.uniform(-1, 1), random.uniform(-1, 1)};
  Shape& s = face.solid;
  face.centre = c;
  face.radius = random.uniform(0.2, 1.4);
  const Vec3 here{c.x, c.y, z}, there{c.x, c.y, z + up * random.uniform(0.5, 1.5)};
  s.from = here, s.to = there, s.radius = face.radius;
  switch (kind) {
    case 0:
      s.kind = ShapeKind::kCylinder;
      if (random.chance(0.5)) std::swap(s.from, s.to);
      break;
    case 1:
      s.kind = ShapeKind::kCone;
      break;
    case 2:
      s.kind = ShapeKind::kFrustum;
      s.end_radius = random.uniform(0, 1.5);
      if (random.chance(0.5)) {
        std::swap(s.from, s.to);
        std::swap(s.radius, s.end_radius);
      }
      break;
    case 3: {
      const double a = random.uniform(0, pi), hx = random.uniform(0.2, 1.2), hy = random.uniform(0.2, 1.2);
      s.kind = ShapeKind::kBox;
      s.size = {2 * hx, 2 * hy, 1};
      s.from = {c.x, c.y, z + 0.5 * up};
      s.q_BS = {std::cos(0.5 * a), 0, 0, std::sin(0.5 * a)};
      for (const auto& [x, y] : {Point{-hx, -hy}, Point{hx, -hy}, Point{hx, hy}, Point{-hx, hy}})
        face.corners.push_back({c.x + x * std::cos(a) - y * std::sin(a), c.y + x * std::sin(a) + y * std::cos(a)});
      break;
    }
    default: {
      s.kind = ShapeKind::kHull;
      const int count = 3 + random.below(7);
      const double first = random.uniform(0, 1);
      for (int i = 0; i < count; ++i) {
        const double a = 2 * pi * (i + first + random.uniform(0, 0.4)) / count;
        face.corners.push_back({c.x + face.radius * std::cos(a), c.y + face.radius * std::sin(a)});
      }
      for (const Point& p : face.corners) s.points.push_back({p.x, p.y, z});
      for (const Point& p : face.corners)  // the other end is smaller
        s.points.push_back({c.x + 0.5 * (p.x - c.x), c.y + 0.5 * (p.y - c.y), z + up});
      s.points.push_back({c.x, c.y, z});  // within the face
      break;
    }
  }
  return face;
}

// Centre of the common area, and that area.
double sum_common(const Face& a, const Face& b, Point& centre) {
  constexpr double kWidth = 2 * kReach / kStrips;
  double area = 0, x_moment = 0, y_moment = 0;
  for (int i = 0; i < kStrips; ++i) {
    const double x = -kReach + (i + 0.5) * kWidth;
    const auto [a_low, a_high] = a.get_range(x);
    const auto [b_low, b_high] = b.get_range(x);
    if (a_low > a_high || b_low > b_high) continue;
    const double low = std::max(a_low, b_low), high = std::min(a_high, b_high);
    if (low >= high) continue;
    area += kWidth * (high - low);
    x_moment += kWidth * (high - low) * x;
    y_moment += kWidth * (high - low) * 0.5 * (low + high);
  }
  centre = {x_moment / area, y_moment / area};
  return area;
}

void expect_witness(const Distance& d, const Point& centre, double tolerance) {
  EXPECT_NEAR(d.distance, kGap, 1e-12);
  EXPECT_NEAR(d.normal.z, 1, 1e-12);
  EXPECT_NEAR(d.on_a.x, centre.x, tolerance);
  EXPECT_NEAR(d.on_a.y, centre.y, tolerance);
  EXPECT_NEAR(d.on_a.z, 0, 1e-12);
  EXPECT_NEAR(d.on_b.x, centre.x, tolerance);
  EXPECT_NEAR(d.on_b.y, centre.y, tolerance);
  EXPECT_NEAR(d.on_b.z, kGap, 1e-12);
}

TEST(GeometryFaces, OfEveryTwoKindsMeetInTheCentreOfTheirCommonArea) {
  constexpr std::uint64_t kSeed = 481;
  constexpr int kEach = 40;
  Random random(kSeed);
  int judged = 0;
  for (int kind_a = 0; kind_a < 5; ++kind_a)
    for (int kind_b = 0; kind_b < 5; ++kind_b)
      for (int i = 0; i < kEach; ++i) {
        const Face a = draw_face(random, kind_a, -1, 0), b = draw_face(random, kind_b, 1, kGap);
        Point centre{};
        if (!(sum_common(a, b, centre) > 0.02)) continue;  // they pass each other, or a thin sliver's sum is inexact
        ++judged;
        SCOPED_TRACE(std::to_string(kind_a) + " " + std::to_string(kind_b) + " pair " + std::to_string(i));
        expect_witness(calc_distance(compile_shape(a.solid), {}, compile_shape(b.solid), {}), centre, kOfSums);
        if (HasFailure()) return;
      }
  EXPECT_GT(judged, 25 * kEach / 2);
}

// A line of a solid that lies on it: a capsule, a cylinder, a cone on its side, a box on its edge.
struct Line {
  Shape solid;
  Point from, to;
};
Line draw_line(Random& random, int kind) {
  Line line;
  Shape& s = line.solid;
  const Point c{random.uniform(-1, 1), random.uniform(-1, 1)};
  const double a = random.uniform(0, 2 * pi), half = random.uniform(0.3, 2), r = random.uniform(0.1, 0.5);
  const Point e{std::cos(a), std::sin(a)};
  line.from = {c.x - half * e.x, c.y - half * e.y};
  line.to = {c.x + half * e.x, c.y + half * e.y};
  s.from = {line.from.x, line.from.y, kGap + r};
  s.to = {line.to.x, line.to.y, kGap + r};
  s.radius = r;
  s.kind = kind == 0 ? ShapeKind::kCapsule : ShapeKind::kCylinder;
  if (kind == 2) {  // the side is a generator of the cone: its axis rises by the half angle of the apex at `from`
    const double angle = std::atan2(r, 2 * half), length = 2 * half * std::cos(angle);
    const double radius = length * std::tan(angle);
    s.kind = ShapeKind::kCone;
    s.to = {line.from.x, line.from.y, kGap};  // the apex
    const double along = length * std::cos(angle), high = length * std::sin(angle);
    s.from = {line.from.x + along * e.x, line.from.y + along * e.y, kGap + high};
    s.radius = radius;
  } else if (kind == 3) {  // a box that is turned by an eighth about its long axis
    s.kind = ShapeKind::kBox;
    s.size = {2 * half, 2 * r, 2 * r};
    s.from = {c.x, c.y, kGap + r * std::sqrt(2.0)};
    const Quat about_z{std::cos(0.5 * a), 0, 0, std::sin(0.5 * a)}, about_x{std::cos(pi / 8), std::sin(pi / 8), 0, 0};
    s.q_BS = about_z * about_x;
  }
  return line;
}

TEST(GeometryFaces, OfEveryKindMeetALineInTheMiddleOfItsPartInside) {
  constexpr std::uint64_t kSeed = 482;
  constexpr int kEach = 60, kSamples = 100000;
  Random random(kSeed);
  int judged = 0;
  for (int kind = 0; kind < 5; ++kind)
    for (int of_line = 0; of_line < 4; ++of_line)
      for (int i = 0; i < kEach; ++i) {
        const Face a = draw_face(random, kind, -1, 0);
        const Line line = draw_line(random, of_line);
        const auto get = [&](double t) {
          return Point{line.from.x + t * (line.to.x - line.from.x), line.from.y + t * (line.to.y - line.from.y)};
        };
        double first = 2, last = -1;
        for (int k = 0; k <= kSamples; ++k) {
          const double t = static_cast<double>(k) / kSamples;
          const Point p = get(t);
          if (!a.holds(p.x, p.y)) continue;
          first = std::min(first, t), last = t;
        }
        if (!(last - first > 0.01)) continue;
        ++judged;
        const double sampled = 5.0 / kSamples;  // m: one sample of at most 4 m, at both ends
        SCOPED_TRACE(std::to_string(kind) + " " + std::to_string(of_line) + " pair " + std::to_string(i));
        expect_witness(calc_distance(compile_shape(a.solid), {}, compile_shape(line.solid), {}),
                       get(0.5 * (first + last)), sampled);
        if (HasFailure()) return;
      }
  EXPECT_GT(judged, 20 * kEach / 2);
}

// The lowest point of a half wall: of its rims, half circles about the axis.
double find_lowest(const Shape& wall, const Placement& at) {
  constexpr int kAngles = 20000;
  const Vec3 way = wall.to - wall.from, axis = (1 / norm(way)) * way, side = (1 / norm(wall.side)) * wall.side;
  const Vec3 across = cross(axis, side);
  double least = HUGE_VAL;
  for (const auto& point : wall.profile)
    for (int i = 0; i <= kAngles; ++i) {
      const double angle = pi * (static_cast<double>(i) / kAngles - 0.5);
      const Vec3 p = wall.from + point.z * axis + point.r * (std::cos(angle) * side + std::sin(angle) * across);
      least = std::min(least, (at.p_WB + at.R_WB * p).z);
    }
  return least;
}

TEST(GeometryFaces, AHalfWallIsAsHighAsItsLowestRimHoweverItStandsLiesOrLeans) {
  constexpr double kOfAngles = 1e-8;  // m: half the square of a step of the angle
  const Shape ground{.kind = ShapeKind::kHalfSpace, .normal = {0, 0, 1}};
  const Shape wall{.kind = ShapeKind::kHollow,
                   .to = {0, 0, 2},
                   .profile = {{0, 0.5}, {1, 1}, {2, 1}},
                   .half = true,
                   .side = {1, 0, 0}};
  const CompiledShape plane = compile_shape(ground), half = compile_shape(wall);
  const double lean = std::atan2(0.5, 1.0);  // of the conical part's generator
  int flat = 0;
  for (int about_x = 0; about_x < 8; ++about_x)
    for (int about_y = 0; about_y < 8; ++about_y)
      for (const double more : {0.0, lean, -lean, pi / 2 - lean, 0.3}) {
        const double x = about_x * pi / 4, y = about_y * pi / 4 + more;
        const Mat3 R = rotation_matrix(Quat{std::cos(0.5 * x), std::sin(0.5 * x), 0, 0}) *
                       rotation_matrix(Quat{std::cos(0.5 * y), 0, std::sin(0.5 * y), 0});
        const Placement at{{0.25, -0.5, 5}, R};
        const Distance d = calc_distance(plane, {}, half, at);
        ASSERT_NEAR(d.distance, find_lowest(wall, at), kOfAngles) << about_x << " " << about_y << " " << more;
        ASSERT_NEAR(d.on_b.z, d.distance, 1e-12);
        ASSERT_NEAR(d.on_a.z, 0, 1e-12);
        flat += std::abs(R.z.z) > 1 - 1e-12;
      }
  EXPECT_EQ(flat, 4) << "attitudes in which it stands";
  // Upright the witness is the middle of the half disc, which a polygon of 32 sides replaces.
  const Distance d = calc_distance(plane, {}, half, {{0, 0, 1}, kIdentity3});
  EXPECT_NEAR(d.distance, 1, 1e-14);
  EXPECT_NEAR(d.on_b.x, 4 * 0.5 / (3 * pi), 1e-3 * 0.5);
  EXPECT_NEAR(d.on_b.y, 0, 1e-14);
}

// Both orders of the arguments compute one and the same: no order of two shapes may depend on which comes first.
TEST(GeometryFaces, ExchangeMirrorsTheBitsOfShapesThatDifferInOneNumber) {
  const Placement home{{0.1, 0.2, 0.3}, rotation_matrix(normalized(Quat{1, 0.2, -0.1, 0.4}))};
  struct Pair {
    const char* difference;
    Shape a, b;
    Placement at_a, at_b;
  };
  std::vector<Pair> pairs;
  const Shape cylinder{.kind = ShapeKind::kCylinder, .from = {0, 0, -4}, .to = {0, 0, 4}, .radius = 3};
  const Shape wide{.kind = ShapeKind::kCylinder, .from = {0, 0, -3}, .to = {0, 0, 3}, .radius = 4};
  pairs.push_back({"radius and length, of one bound", cylinder, wide, home, home});
  const Shape frustum{.kind = ShapeKind::kFrustum, .from = {0, 0, -4}, .to = {0, 0, 4}, .radius = 3, .end_radius = 1};
  Shape blunt = frustum;
  blunt.end_radius = 2;
  pairs.push_back({"radius of the narrow end", frustum, blunt, home, home});
  const Shape box{.kind = ShapeKind::kBox, .size = {1, 2, 3}};
  for (const Vec3& size : {Vec3{2, 1, 3}, Vec3{1, 3, 2}, Vec3{3, 2, 1}}) {
    Shape other = box;
    other.size = size;
    pairs.push_back({"order of the edges", box, other, home, home});
  }
  for (const Vec3& way : {Vec3{0.5, 0, 0}, Vec3{0, 0.5, 0}, Vec3{0, 0, 0.5}}) {
    Shape moved = box;
    moved.from = way;
    pairs.push_back({"place in the body", box, moved, home, home});
    pairs.push_back({"place of the body", box, box, home, {home.p_WB + way, home.R_WB}});
  }
  for (const Quat& turn : {Quat{1, 0.3, 0, 0}, Quat{1, 0, 0.3, 0}, Quat{1, 0, 0, 0.3}}) {
    Shape turned = box;
    turned.q_BS = normalized(turn);
    pairs.push_back({"attitude in the body", box, turned, home, home});
    pairs.push_back({"attitude of the body", box, box, home, {home.p_WB, rotation_matrix(normalized(turn))}});
  }
  Shape hull{.kind = ShapeKind::kHull}, other;
  hull.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0.5, 0.5, 0.5}};
  other = hull, other.points[6].z = 0.55;
  pairs.push_back({"one point of a hull", hull, other, home, home});
  other = hull, other.points.pop_back();
  pairs.push_back({"number of a hull's points", hull, other, home, home});
  pairs.push_back({"nothing", hull, hull, home, home});
  for (const Pair& pair : pairs) {
    SCOPED_TRACE(pair.difference);
    const CompiledShape a = compile_shape(pair.a), b = compile_shape(pair.b);
    const Distance d = calc_distance(a, pair.at_a, b, pair.at_b), e = calc_distance(b, pair.at_b, a, pair.at_a);
    EXPECT_LT(d.distance, 0) << "they overlap";
    EXPECT_EQ(std::memcmp(&d.distance, &e.distance, sizeof(double)), 0);
    if (pair.difference == std::string("nothing")) continue;  // which of the two is A nobody can say
    EXPECT_EQ(norm(d.normal + e.normal), 0);
    EXPECT_EQ(norm(d.on_a - e.on_b), 0);
    EXPECT_EQ(norm(d.on_b - e.on_a), 0);
  }
}

// Rigid contacts ask for the distance of a centre; within a solid, and on its surface, no direction leads out of it.
TEST(GeometryFaces, ASphereWhoseCentreIsNotOutsideOfASolidIsReported) {
  const CompiledShape ball = compile_shape({.kind = ShapeKind::kSphere, .radius = 0.25});
  const Shape solids[] = {{.kind = ShapeKind::kBox, .size = {2, 2, 2}},
                          {.kind = ShapeKind::kCylinder, .from = {0, 0, -1}, .to = {0, 0, 1}, .radius = 1},
                          {.kind = ShapeKind::kCapsule, .from = {-1, 0, 0}, .to = {1, 0, 0}, .radius = 0.5}};
  for (const Shape& solid : solids) {
    const CompiledShape other = compile_shape(solid);
    const auto measure = [&](double z) { return calc_sphere_distance(ball, {{0, 0, z}, kIdentity3}, other, {}); };
    const double top = solid.kind == ShapeKind::kCapsule ? 0 : 1;  // of the core
    EXPECT_FALSE(measure(top).outside);
    if (top > 0) {
      EXPECT_FALSE(measure(0.5).outside);
    }
    const geometry::SphereDistance above = measure(2);
    ASSERT_TRUE(above.outside);
    EXPECT_NEAR(above.distance, 2 - 0.25 - (top > 0 ? 1 : 0.5), 1e-15);
    EXPECT_NEAR(above.bend, 1 / (2 - top), 1e-15);
    EXPECT_EQ(above.normal.z, 1);
  }
}

}  // namespace
}  // namespace unlatch::test::faces_test
