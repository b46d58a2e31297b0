#include "tests/kernel/geometry/wall_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace unlatch::test {
namespace {

using geometry::Placement;
using geometry::ProfilePoint;
using geometry::Shape;
using geometry::ShapeKind;

constexpr double kPi = 3.14159265358979323846;
constexpr double kGolden = 0.38196601125010515;

// Least value of a function with one minimum between two arguments, by golden section.
template <typename Function>
double minimise(const Function& f, double low, double high, int steps) {
  double a = low + kGolden * (high - low), b = high - kGolden * (high - low);
  double of_a = f(a), of_b = f(b), least = std::min({f(low), f(high), of_a, of_b});
  for (int i = 0; i < steps; ++i) {
    if (of_a < of_b) {
      high = b, b = a, of_b = of_a;
      a = low + kGolden * (high - low), of_a = f(a);
    } else {
      low = a, a = b, of_a = of_b;
      b = high - kGolden * (high - low), of_b = f(b);
    }
    least = std::min({least, of_a, of_b});
  }
  return least;
}

// Point of the wall between two points of its profile.
Vec3 calc_wall_point(const ProfilePoint& from, const ProfilePoint& to, double azimuth, double share) {
  const double r = from.r + share * (to.r - from.r), z = from.z + share * (to.z - from.z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

// Range of a wall's azimuths, rad.
struct Azimuths {
  double first, last;
};

Azimuths get_azimuths(const Shape& wall) { return wall.half ? Azimuths{-0.5 * kPi, 0.5 * kPi} : Azimuths{-kPi, kPi}; }

// Least value over the wall's azimuths of a function that changes by at most `rate` a radian: at steps of the range
// where it can be less than the least so far (Piyavskii 1972, Shubert 1972), then by golden section about each of the
// least steps.
template <typename Coarse, typename Fine>
double minimise_around(const Shape& wall, double rate, const Coarse& coarse, const Fine& fine) {
  constexpr int kSteps = 512, kFirst = 32;  // powers of two
  constexpr double kSlack = 1e-4;           // m, of the steps' values
  const auto [first, last] = get_azimuths(wall);
  const double step = (last - first) / kSteps;
  double values[kSteps + 1];
  std::fill(std::begin(values), std::end(values), std::numeric_limits<double>::infinity());
  double best = std::numeric_limits<double>::infinity();
  const auto measure = [&](int k) { best = std::min(best, values[k] = coarse(first + k * step)); };
  for (int k = 0; k <= kSteps; k += kSteps / kFirst) measure(k);
  for (int width = kSteps / kFirst; width > 1; width /= 2) {
    for (int k = 0; k < kSteps; k += width)
      if (0.5 * (values[k] + values[k + width] - rate * width * step) < best + kSlack) measure(k + width / 2);
  }
  double least = best;
  for (int k = 0; k <= kSteps; ++k) {
    const double left = k > 0 ? values[k - 1] : (wall.half ? values[k] : values[kSteps - 1]);
    const double right = k < kSteps ? values[k + 1] : (wall.half ? values[k] : values[1]);
    if (values[k] > left || values[k] > right || values[k] > best + rate * step + kSlack) continue;
    const double angle = first + k * step, low = angle - step, high = angle + step;
    least = std::min(
        least, minimise(fine, wall.half ? std::max(first, low) : low, wall.half ? std::min(last, high) : high, 44));
  }
  return least;
}

}  // namespace

double search_wall(const Shape& wall, const Shape& body, const Placement& at) {
  const PointDistance distance(body, at);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < wall.profile.size(); ++i) {
    const ProfilePoint &from = wall.profile[i], &to = wall.profile[i + 1];
    // A distance to a convex solid is convex along a generator.
    const auto of_generator = [&](double azimuth, int steps) {
      return minimise([&](double share) { return distance(calc_wall_point(from, to, azimuth, share)); }, 0, 1, steps);
    };
    // Points of a generator move by their radius a radian, and a distance changes by no more than its point moves.
    least = std::min(least, minimise_around(
                                wall, std::max(from.r, to.r), [&](double azimuth) { return of_generator(azimuth, 24); },
                                [&](double azimuth) { return of_generator(azimuth, 46); }));
    if (least == 0) return 0;
  }
  return least;
}

double search_crossed_wall(const Shape& wall, const Shape& body, const Placement& at) {
  const ProfilePoint &from = wall.profile[0], &to = wall.profile[1];
  // Translation along n that leads the body out of the strip. A strip is unbounded along its tangent, but for that of a
  // half wall, which ends on the plane x = 0; n leans from the meridian plane towards that end.
  const auto calc_way_out = [&](double azimuth, double angle, double lean) {
    const double c = std::cos(azimuth), s = std::sin(azimuth), side = azimuth < 0 ? -1 : 1;
    const double along = std::cos(lean) * std::cos(angle), across = std::sin(lean) * side;
    const Vec3 n{along * c - across * s, along * s + across * c, std::cos(lean) * std::sin(angle)};
    const auto calc_end = [&](const ProfilePoint& p) {
      return lean > 0 ? n.y * p.r / s + n.z * p.z : along * p.r + n.z * p.z;
    };
    return std::max(calc_end(from), calc_end(to)) + calc_extent(body, at, -n);
  };
  constexpr double kMostLean = 0.5 * kPi;
  const auto calc_depth = [&](double azimuth) {
    constexpr int kAngles = 120, kLeans = 8;
    const int leans = wall.half && std::fabs(azimuth) > 1e-6 ? kLeans : 0;
    constexpr double kAngleStep = 2 * kPi / kAngles, kLeanStep = kMostLean / kLeans;
    std::vector<double> coarse;
    for (int lean = 0; lean <= leans; ++lean)
      for (int k = 0; k < kAngles; ++k) coarse.push_back(calc_way_out(azimuth, k * kAngleStep, lean * kLeanStep));
    const double least = *std::min_element(coarse.begin(), coarse.end());
    double depth = least;
    const auto get = [&](int lean, int k) {
      return coarse[static_cast<std::size_t>(std::clamp(lean, 0, leans) * kAngles + (k + kAngles) % kAngles)];
    };
    for (int lean = 0; lean <= leans; ++lean) {
      for (int k = 0; k < kAngles; ++k) {
        const double here = get(lean, k);
        if (here > least + 0.1 ||
            here > std::min({get(lean, k - 1), get(lean, k + 1), get(lean - 1, k), get(lean + 1, k)}))
          continue;
        const double angle = k * kAngleStep, low = std::max(0.0, (lean - 1) * kLeanStep);
        const double high = std::min(kMostLean, (lean + 1) * kLeanStep);
        const auto of_angle = [&](double a) {
          if (leans == 0) return calc_way_out(azimuth, a, 0);
          return minimise([&](double l) { return calc_way_out(azimuth, a, l); }, low, high, 36);
        };
        depth = std::min(depth, minimise(of_angle, angle - kAngleStep, angle + kAngleStep, 36));
      }
    }
    return depth;
  };
  const auto in = [&](double azimuth) { return -calc_depth(azimuth); };
  // A turning strip moves its points, and so its way out, by no more than the body is away from the axis.
  double reach = 0;
  for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}})
    reach = std::max(reach, std::sqrt(2.0) * calc_extent(body, at, n));
  const double height = minimise_around(wall, reach, in, in);
  const auto calc_solid_extent = [&](const Vec3& n) {
    const double radial = wall.half && n.x < 0 ? std::fabs(n.y) : std::hypot(n.x, n.y);
    return std::max(from.r * radial + n.z * from.z, to.r * radial + n.z * to.z);
  };
  constexpr int kDirections = 1500, kStarts = 8;
  const double out = -search_directions([&](const Vec3& n) { return calc_solid_extent(n) + calc_extent(body, at, -n); },
                                        kDirections, kStarts);
  return std::max(height, out);
}

}  // namespace unlatch::test
