#include "tools/modes/shell_beams.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace unlatch::tools {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kLikeness = 0.5;  // MAC below which a mode is not the beam's; those that are reach 0.9

// The arc's shape at an angle, between its points.
Vector3d calc_displacement(const ArcMode& mode, double angle) {
  const double at = angle / std::numbers::pi * static_cast<double>(mode.radial.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(std::max(at, 0.0)), mode.radial.size() - 2);
  const double s = at - static_cast<double>(i);
  const double w = (1 - s) * mode.radial[i] + s * mode.radial[i + 1];
  const double u = (1 - s) * mode.tangential[i] + s * mode.tangential[i + 1];
  return {w * std::cos(angle) - u * std::sin(angle), w * std::sin(angle) + u * std::cos(angle), 0};
}

// Share of a mode's mass that lies in span{field, (z − middle) field}: MAC with the best of them. The two are
// orthogonal over a cylinder that is meshed evenly about its middle.
double calc_likeness(const hil::Modes& modes, Index mode, const HalfShell& shell, const ArcMode& arc) {
  double whole = 0;
  Eigen::Vector2d along = Eigen::Vector2d::Zero();
  Eigen::Matrix2d gram = Eigen::Matrix2d::Zero();
  for (const hil::ModalPoint& point : modes.points) {
    if (point.position.z() > shell.cylinder) continue;
    const Vector3d field = calc_displacement(arc, std::atan2(point.position.y(), point.position.x()));
    const Eigen::Vector2d amplitude(1, point.position.z() / shell.cylinder - 0.5);
    whole += point.mass * point.shape.col(mode).squaredNorm();
    along += point.mass * point.shape.col(mode).dot(field) * amplitude;
    gram += point.mass * field.squaredNorm() * amplitude * amplitude.transpose();
  }
  // A mode that is the field times z alone is a twist of the whole shell: the even part must lead.
  const Eigen::Vector2d share = gram.ldlt().solve(along);
  const double mean = gram(0, 0) * share[0] * share[0], tilt = gram(1, 1) * share[1] * share[1];
  return mean > tilt ? along.dot(share) / whole : 0;
}

// Mirrored about x = 0, points stay points: the mesh is symmetric, column for column.
double calc_even_share(const hil::Modes& modes, Index mode) {
  double even = 0, whole = 0;
  for (const hil::ModalPoint& point : modes.points) {
    const Vector3d mirrored(-point.position.x(), point.position.y(), point.position.z());
    const auto twin = std::min_element(
        modes.points.begin(), modes.points.end(), [&](const hil::ModalPoint& a, const hil::ModalPoint& b) {
          return (a.position - mirrored).squaredNorm() < (b.position - mirrored).squaredNorm();
        });
    const Vector3d here = point.shape.col(mode), there = twin->shape.col(mode);
    const Vector3d sum = 0.5 * (here + Vector3d(-there.x(), there.y(), there.z()));
    even += point.mass * sum.squaredNorm();
    whole += point.mass * here.squaredNorm();
  }
  return even / whole;
}

}  // namespace

double calc_arc_hz(double omega, double radius, double thickness, double young, double density, double poisson,
                   bool plate) {
  const double modulus = plate ? young / (1 - poisson * poisson) : young;
  const double bending = modulus * thickness * thickness * thickness / 12, mass = density * thickness;
  return omega * std::sqrt(bending / mass) / (radius * radius) / (2 * std::numbers::pi);
}

std::vector<ShellModeFinding> match_beams(const hil::Modes& modes, const HalfShell& shell,
                                          const std::vector<ArcMode>& arc) {
  std::vector<ShellModeFinding> findings(static_cast<std::size_t>(modes.get_count()));
  for (std::size_t k = 0; k < findings.size(); ++k) {
    const double even = calc_even_share(modes, static_cast<Index>(k));
    findings[k].even = even > 0.5;
    findings[k].symmetry = std::max(even, 1 - even);
  }
  for (std::size_t beam = 0; beam < arc.size(); ++beam) {
    std::size_t best = 0;
    double likeness = 0;
    for (std::size_t k = 0; k < findings.size(); ++k) {
      const double found = calc_likeness(modes, static_cast<Index>(k), shell, arc[beam]);
      if (findings[k].beam == 0 && found > likeness) {
        best = k;
        likeness = found;
      }
    }
    if (likeness < kLikeness) continue;
    findings[best].beam = static_cast<int>(beam) + 1;
    findings[best].likeness = likeness;
  }
  return findings;
}

}  // namespace unlatch::tools
