// Small helpers of the tests of flight near a planet.
#pragma once

#include <cmath>
#include <numbers>

#include "tests/support/random.h"
#include "unlatch/math.h"
#include "unlatch/model/environment.h"

namespace unlatch::test {

inline Eigen::Vector3d to_eigen(const Vec3& v) { return {v.x, v.y, v.z}; }

inline Eigen::Vector3d draw_direction(Random& random) {
  const double z = random.uniform(-1, 1), turn = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double across = std::sqrt(1 - z * z);
  return {across * std::cos(turn), across * std::sin(turn), z};
}

// −potential, long double so that differences of it keep their digits.
inline long double calc_potential(const Planet& planet, const Eigen::Vector3d& at) {
  using Long = long double;
  const Long x = at.x(), y = at.y(), z = at.z(), r = std::sqrt(x * x + y * y + z * z);
  const Eigen::Vector3d& n = planet.pole;
  const Long s = (x * Long(n.x()) + y * Long(n.y()) + z * Long(n.z())) / r, a = Long(planet.radius) / r;
  return Long(planet.mu) / r * (1 - Long(planet.j2) * a * a * (3 * s * s - 1) / 2);
}

}  // namespace unlatch::test
