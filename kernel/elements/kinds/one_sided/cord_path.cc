#include "kernel/elements/kinds/one_sided/cord_path.h"

#include <algorithm>
#include <cmath>

#include "kernel/math/angles.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

// The path seen along the drum's axis: its length, and the gradient of that.
struct PlanarPath {
  double length, x, y;
};

// Along the drum to where a tangent leaves it for the end, and on along that. `straight`: length of the tangent, 0 for
// an end inside the drum, whose path is r times its bearing.
PlanarPath calc_wound(double r, double x, double y, double rho, double straight, double bearing, double winding) {
  if (rho == 0) return {r * winding, 0, 0};
  const double side = bearing < 0 ? -1 : 1, inner = std::min(r, rho), square = rho * rho;
  const double cosine = (inner * x + side * straight * y) / square, sine = (inner * y - side * straight * x) / square;
  const double slope = side * (r / inner);
  return {r * winding + straight, -(slope * sine), slope * cosine};
}

// From the anchor to the end, past the drum.
PlanarPath calc_straight(double r, double x, double y) {
  const double along = x - r, length = std::sqrt(along * along + y * y);
  if (length == 0) return {0, 0, 0};
  return {length, along / length, y / length};
}

}  // namespace

CordPath calc_cord_path(const CordDrum& drum, const Mat3& R_WB, const Vec3& end, double previous) noexcept {
  const Mat3 axes = R_WB * drum.axes;
  const Vec3 e = transpose_times(axes, end - R_WB * drum.centre);
  const double r = drum.radius, rho = std::sqrt(e.x * e.x + e.y * e.y);
  const double straight = std::sqrt(std::max(0.0, (rho - r) * (rho + r)));
  CordPath path{};
  path.bearing = rho > 0 ? unwind(elementary::atan2(e.y, e.x), previous) : previous;
  path.winding = std::abs(path.bearing) - elementary::atan2(straight, r);
  const bool wound = path.winding > 0 || rho < r;
  const PlanarPath planar =
      wound ? calc_wound(r, e.x, e.y, rho, straight, path.bearing, path.winding) : calc_straight(r, e.x, e.y);
  // The cylinder and the tangent plane unroll into one plane, in which the cord is straight.
  path.length = std::sqrt(planar.length * planar.length + e.z * e.z);
  if (path.length > 0) {
    const double slope = planar.length / path.length;
    path.direction = axes * Vec3{slope * planar.x, slope * planar.y, e.z / path.length};
    if (wound) path.on_drum = slope > 0 ? r * path.winding / slope : 0;
  }
  return path;
}

}  // namespace unlatch
