// Signed distances of pairs of shapes: `distance/<shape>-<shape>` apart, `distance/<shape>-<shape>/overlap` shallow
// overlaps, `distance/hollow-<shape>` in a tube; `distance/fcl/<shape>-<shape>` the same pairs apart by FCL's GJK,
// distance alone. Each passes through 64 pairs in random attitudes, at gaps of 0.1 to 1 m between shapes of about 1 m.
#include <benchmark/benchmark.h>
#include <fcl/narrowphase/distance.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "bench/least.h"
#include "tests/kernel/geometry/solids.h"

namespace unlatch::test {
namespace {

using geometry::CompiledShape;
using geometry::Distance;
using geometry::Placement;
using geometry::Shape;
using geometry::ShapeKind;

constexpr int kPairs = 64;

struct Pair {
  Shape shape_a, shape_b;
  CompiledShape a, b;
  Placement at_a, at_b;
};

// Builds pairs. `low` and `high`: limits of the distance, m.
std::vector<Pair> build_pairs(int kind_a, int kind_b, double low, double high) {
  Random random(static_cast<std::uint64_t>(10 * kind_a + kind_b));
  std::vector<Pair> pairs;
  while (pairs.size() < static_cast<std::size_t>(kPairs)) {
    Pair pair;
    pair.shape_a = draw_shape(random, kConvexKinds[kind_a]);
    pair.shape_b = draw_shape(random, kConvexKinds[kind_b]);
    pair.a = compile_shape(pair.shape_a);
    pair.b = compile_shape(pair.shape_b);
    pair.at_a = draw_placement(random, 2);
    pair.at_b = draw_placement(random, 2);
    const double d = calc_distance(pair.a, pair.at_a, pair.b, pair.at_b).distance;
    if (d > low && d < high) pairs.push_back(std::move(pair));
  }
  return pairs;
}

void run_pairs(benchmark::State& state, const std::vector<Pair>& pairs) {
  std::size_t i = 0;
  for (auto _ : state) {
    const Pair& pair = pairs[i++ % pairs.size()];
    benchmark::DoNotOptimize(calc_distance(pair.a, pair.at_a, pair.b, pair.at_b));
  }
}

// Runs a sphere, capsule or cylinder of half the radius in a tube.
void run_tube(benchmark::State& state, int kind) {
  Shape tube{.kind = ShapeKind::kHollow, .to = {0, 0, 1}, .profile = {{0, 1}, {3, 1}}};
  const CompiledShape a = compile_shape(tube);
  Shape inside{.kind = kConvexKinds[kind], .from = {0.1, 0, 1}, .to = {0.15, 0.1, 2}, .radius = 0.5};
  const CompiledShape b = compile_shape(inside);
  for (auto _ : state) benchmark::DoNotOptimize(calc_distance(a, {}, b, {}));
}

// --- FCL
// --------------------------------------------------------------------------------------------------------------

struct FclPair {
  std::shared_ptr<fcl::CollisionGeometryd> a, b;
  alignas(16) fcl::Transform3d at_a, at_b;  // as in hil/scenario/shapes/mesh_module.cc
};

// Shape of a kind that FCL has; its axes are centred.
std::shared_ptr<fcl::CollisionGeometryd> build_fcl(const CompiledShape& shape, ShapeKind kind) {
  const double length = 2 * shape.half_length;
  switch (kind) {
    case ShapeKind::kSphere:
      return std::make_shared<fcl::Sphered>(shape.r0);
    case ShapeKind::kCapsule:
      return std::make_shared<fcl::Capsuled>(shape.r0, length);
    case ShapeKind::kCylinder:
      return std::make_shared<fcl::Cylinderd>(shape.r0, length);
    case ShapeKind::kCone:
      return std::make_shared<fcl::Coned>(shape.r0, length);
    default:
      return std::make_shared<fcl::Boxd>(2 * shape.half_size.x, 2 * shape.half_size.y, 2 * shape.half_size.z);
  }
}

fcl::Transform3d build_transform(const CompiledShape& shape, const Placement& at) {
  const Mat3 R = at.R_WB * shape.R_BS;
  const Vec3 p = at.p_WB + at.R_WB * shape.p_BS;
  fcl::Transform3d out = fcl::Transform3d::Identity();
  for (int k = 0; k < 3; ++k) out.linear().col(k) << column(R, k).x, column(R, k).y, column(R, k).z;
  out.translation() << p.x, p.y, p.z;
  return out;
}

void run_fcl(benchmark::State& state, const std::vector<Pair>& pairs) {
  std::vector<FclPair> ours;
  for (const Pair& pair : pairs)
    ours.push_back({build_fcl(pair.a, pair.shape_a.kind), build_fcl(pair.b, pair.shape_b.kind),
                    build_transform(pair.a, pair.at_a), build_transform(pair.b, pair.at_b)});
  std::size_t i = 0;
  for (auto _ : state) {
    const FclPair& pair = ours[i++ % ours.size()];
    fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    benchmark::DoNotOptimize(fcl::distance(pair.a.get(), pair.at_a, pair.b.get(), pair.at_b, request, result));
  }
}

const int registered = [] {
  constexpr const char* kNames[] = {"sphere", "capsule", "cylinder", "cone", "frustum", "box", "hull"};
  for (int a = 0; a < 7; ++a) {
    for (int b = a; b < 7; ++b) {
      const std::string name = std::string(kNames[a]) + "-" + kNames[b];
      benchmark::RegisterBenchmark(("distance/" + name).c_str(), [a, b](benchmark::State& state) {
        run_pairs(state, build_pairs(a, b, 0.1, 1));
      })->Apply(bench::keep_least);
      benchmark::RegisterBenchmark(("distance/" + name + "/overlap").c_str(), [a, b](benchmark::State& state) {
        run_pairs(state, build_pairs(a, b, -0.05, 0));
      })->Apply(bench::keep_least);
      if (a != 4 && b != 4 && b != 6)
        benchmark::RegisterBenchmark(("distance/fcl/" + name).c_str(), [a, b](benchmark::State& state) {
          run_fcl(state, build_pairs(a, b, 0.1, 1));
        })->Apply(bench::keep_least);
    }
  }
  for (int kind = 0; kind < 4; ++kind)
    benchmark::RegisterBenchmark((std::string("distance/hollow-") + kNames[kind]).c_str(),
                                 [kind](benchmark::State& state) { run_tube(state, kind); })
        ->Apply(bench::keep_least);
  return 0;
}();

}  // namespace
}  // namespace unlatch::test
