#include "tests/golden/golden_distances.h"

#include <bit>
#include <cinttypes>
#include <cstdio>

#include "tests/kernel/geometry/solids.h"

namespace unlatch::test {
namespace {

using geometry::Shape;
using geometry::ShapeKind;

constexpr const char* kNames[] = {"sphere", "capsule", "cylinder",   "cone",  "frustum",
                                  "box",    "hull",    "half-space", "hollow"};
constexpr int kPairs = 200;

}  // namespace

void print_distance_hashes() {
  for (int a = 0; a < 9; ++a) {
    for (int b = a; b < 9; ++b) {
      if (a >= 7 && a == b) continue;  // two without distance
      Random random(static_cast<std::uint64_t>(1000 + 10 * a + b));
      std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a over 64-bit words, folded
      for (int i = 0; i < kPairs; ++i) {
        const auto of_a = compile_shape(draw_any(random, a)), of_b = compile_shape(draw_any(random, b));
        const auto at_a = draw_placement(random, 1.5), at_b = draw_placement(random, 1.5);
        const geometry::Distance d = calc_distance(of_a, at_a, of_b, at_b);
        for (const double x : {d.distance, d.on_a.x, d.on_a.y, d.on_a.z, d.on_b.x, d.on_b.y, d.on_b.z, d.normal.x,
                               d.normal.y, d.normal.z, d.gap}) {
          hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3u;
          hash ^= hash >> 32;
        }
      }
      std::printf("distance/%s-%s %d %016" PRIx64 "\n", kNames[a], kNames[b], kPairs, hash);
    }
  }
}

}  // namespace unlatch::test
