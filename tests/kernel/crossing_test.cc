// Estimates of the search for touches within a sub-step: kernel/events/crossing.h.
#include "kernel/events/crossing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "kernel/events/limits.h"

namespace unlatch::test::crossing_test {
namespace {

// Tries until a function that is concave is known to stay below zero, or a try is above; as event_search.cc has them.
int count_looks(const std::function<Flank(double)>& calc, double end) {
  Flank left = calc(0), right = calc(end);
  int looks = 0;
  for (; looks < 100 && may_peak(left, right); ++looks) {
    const Flank peak = calc(looks == 0 ? calc_peak(left, right) : calc_bent_peak(left, right));
    if (peak.value >= 0) return looks + 1;
    (peak.rate > 0 ? left : right) = peak;
  }
  return looks;
}

// A cubesat's edge that nears a lip by 8 mm/s and whose rounded end passes it at 1.7 m/s: its distance is a line up to
// a corner, then a parabola.
TEST(Crossing, ApproachesThatEndAtACornerAreSettledWithinTheLooksOfASubstep) {
  constexpr double kEnd = 1e-3, kRate = 8e-3, kBend = 1445;
  for (const bool mirrored : {false, true})
    for (const double corner : {1e-4, 2.7e-4, 5e-4, 8e-4})
      for (const double peak : {-1e-7, -3e-8, 1e-8}) {
        const double summit = kRate * kRate / (2 * kBend);
        const auto calc = [&](double time) {
          const double t = mirrored ? kEnd - time : time;
          const double behind = std::fmax(0, t - corner);
          const double rate = kRate - kBend * behind;
          return Flank{time, peak - summit + kRate * (t - corner) - 0.5 * kBend * behind * behind,
                       mirrored ? -rate : rate};
        };
        EXPECT_LE(count_looks(calc, kEnd), kMostLooks / 2) << corner << " " << peak << " " << mirrored;
      }
}

TEST(Crossing, SmoothApproachesTakeFewLooks) {
  const auto calc = [](double t) {
    return Flank{t, -2e-8 + 1e-6 * (std::sin(3000 * t) - 1), 3e-3 * std::cos(3000 * t)};
  };
  EXPECT_LE(count_looks(calc, 1e-3), 3);
}

}  // namespace
}  // namespace unlatch::test::crossing_test
