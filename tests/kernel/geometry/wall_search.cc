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

// Distance of a body to the generator of one piece of the wall: convex along it, as the body is.
double search_generator(const Shape& wall, const PointDistance& distance, std::size_t piece, double azimuth,
                        int steps) {
  const ProfilePoint &from = wall.profile[piece], &to = wall.profile[piece + 1];
  return minimise([&](double share) { return distance(calc_wall_point(from, to, azimuth, share)); }, 0, 1, steps);
}

// Range of a wall's azimuths, rad.
struct Azimuths {
  double first, last;
};

Azimuths get_azimuths(const Shape& wall) { return wall.half ? Azimuths{-0.5 * kPi, 0.5 * kPi} : Azimuths{-kPi, kPi}; }

// Least value over the wall's azimuths, or the known one, of a function that changes by at most `rate` a radian: at
// steps of the range where it can be less than the least so far (Piyavskii 1972, Shubert 1972), then by golden section
// about each of the least steps.
template <int kSteps, typename Coarse, typename Fine>
double minimise_around(const Shape& wall, double rate, double known, const Coarse& coarse, const Fine& fine) {
  constexpr int kFirst = 32;       // steps that are tried in any case; both are powers of two
  constexpr double kSlack = 1e-6;  // m, of the steps' values
  const auto [first, last] = get_azimuths(wall);
  const double step = (last - first) / kSteps;
  double values[kSteps + 1];
  std::fill(std::begin(values), std::end(values), std::numeric_limits<double>::infinity());
  double best = known;
  const auto measure = [&, first = first](int k) { best = std::min(best, values[k] = coarse(first + k * step)); };
  for (int k = 0; k <= kSteps; k += kSteps / kFirst) measure(k);
  for (int width = kSteps / kFirst; width > 1; width /= 2) {
    for (int k = 0; k < kSteps; k += width)
      if (0.5 * (values[k] + values[k + width] - rate * width * step) < best + kSlack) measure(k + width / 2);
  }
  double least = known;
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

// True if the body overlaps one of 128 generators: most of those that overlap the wall do.
bool touches_generator(const Shape& wall, const PointDistance& distance) {
  const auto [first, last] = get_azimuths(wall);
  for (std::size_t i = 0; i + 1 < wall.profile.size(); ++i)
    for (int k = 0; k <= 128; ++k)
      if (search_generator(wall, distance, i, first + k * (last - first) / 128, 36) == 0) return true;
  return false;
}

}  // namespace

double search_wall(const Shape& wall, const Shape& body, const Placement& at) {
  const PointDistance distance(body, at);
  if (touches_generator(wall, distance)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < wall.profile.size(); ++i) {
    // Points of a generator move by their radius a radian, and a distance changes by no more than its point moves.
    const double rate = std::max(wall.profile[i].r, wall.profile[i + 1].r);
    const auto of_generator = [&](int steps) {
      return [&, steps](double azimuth) { return search_generator(wall, distance, i, azimuth, steps); };
    };
    least = minimise_around<4096>(wall, rate, least, of_generator(36), of_generator(46));
    if (least == 0) return 0;
  }
  return least;
}

double search_crossed_wall(const Shape& wall, const Shape& body, const Placement& at) {
  const ProfilePoint &from = wall.profile[0], &to = wall.profile[1];
  // Translation along n, given by its parts along the azimuth, along the tangent and up, that leads the body out of the
  // strip. A strip is unbounded along its tangent, but for that of a half wall: it ends where it comes to x = 0.
  const auto calc_way_out = [&](double azimuth, const Vec3& n, double end) {
    const double c = std::cos(azimuth), s = std::sin(azimuth);
    return std::max(n.x * from.r + n.z * from.z, n.x * to.r + n.z * to.z) + n.y * end +
           calc_extent(body, at, -Vec3{n.x * c - n.y * s, n.x * s + n.y * c, n.z});
  };
  const auto calc_across = [&](double azimuth, double angle) {
    return calc_way_out(azimuth, {std::cos(angle), 0, std::sin(angle)}, 0);
  };
  // Directions away from that end are taken as mirrored ones, so that a search meets no border.
  const auto calc_past_end = [&](double azimuth, const Vec3& n) {
    const double end = std::min(from.r, to.r) * std::cos(azimuth) / std::sin(azimuth);
    return calc_way_out(azimuth, {n.x, std::copysign(n.y, end), n.z}, end);
  };
  const auto calc_depth = [&](double azimuth, int directions, int starts) {
    constexpr int kAngles = 240;
    constexpr double kStep = 2 * kPi / kAngles;
    std::vector<double> coarse;
    for (int k = 0; k < kAngles; ++k) coarse.push_back(calc_across(azimuth, k * kStep));
    const double least = *std::min_element(coarse.begin(), coarse.end());
    const auto get = [&](int k) { return coarse[static_cast<std::size_t>((k + kAngles) % kAngles)]; };
    double depth = least;
    for (int k = 0; k < kAngles; ++k) {
      if (get(k) > get(k - 1) || get(k) > get(k + 1) || get(k) > least + 0.1) continue;
      const auto of_angle = [&](double angle) { return calc_across(azimuth, angle); };
      depth = std::min(depth, minimise(of_angle, (k - 1) * kStep, (k + 1) * kStep, 40));
    }
    if (!wall.half || azimuth == 0) return depth;
    return std::min(depth,
                    search_directions([&](const Vec3& n) { return calc_past_end(azimuth, n); }, directions, starts));
  };
  const auto coarse = [&](double azimuth) { return -calc_depth(azimuth, 400, 4); };
  const auto fine = [&](double azimuth) { return -calc_depth(azimuth, 4000, 16); };
  // A turning strip moves its points, and so its way out, by no more than the body is away from the axis.
  double reach = 0;
  for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}})
    reach = std::max(reach, std::sqrt(2.0) * calc_extent(body, at, n));
  const double height = minimise_around<512>(wall, reach, std::numeric_limits<double>::infinity(), coarse, fine);
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
