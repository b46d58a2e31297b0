#include "tools/modes/mesh_modes.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "hil/scenario/text/count.h"

namespace unlatch::tools {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Shape functions of an element and their slopes at a point of it, and the point's weight.
struct GaussPoint {
  Eigen::VectorXd value, slope_a, slope_b;
  double weight;
};

// Corners (±1, ±1), then the mid-sides; serendipity: no node in the middle.
GaussPoint calc_quad(bool quadratic, double a, double b) {
  constexpr double kA[] = {-1, 1, 1, -1, 0, 1, 0, -1}, kB[] = {-1, -1, 1, 1, -1, 0, 1, 0};
  const Eigen::Index count = quadratic ? 8 : 4;
  GaussPoint out{Eigen::VectorXd(count), Eigen::VectorXd(count), Eigen::VectorXd(count), 1};
  for (Eigen::Index i = 0; i < count; ++i) {
    const double p = kA[i], q = kB[i], u = 1 + p * a, v = 1 + q * b;
    if (!quadratic) {
      out.value[i] = u * v / 4;
      out.slope_a[i] = p * v / 4;
      out.slope_b[i] = q * u / 4;
    } else if (i < 4) {
      out.value[i] = u * v * (p * a + q * b - 1) / 4;
      out.slope_a[i] = p * v * (2 * p * a + q * b) / 4;
      out.slope_b[i] = q * u * (p * a + 2 * q * b) / 4;
    } else if (p == 0) {
      out.value[i] = (1 - a * a) * v / 2;
      out.slope_a[i] = -a * v;
      out.slope_b[i] = q * (1 - a * a) / 2;
    } else {
      out.value[i] = (1 - b * b) * u / 2;
      out.slope_a[i] = p * (1 - b * b) / 2;
      out.slope_b[i] = -b * u;
    }
  }
  return out;
}

// Corners at (0, 0), (1, 0), (0, 1), then the mid-sides.
GaussPoint calc_triangle(bool quadratic, double a, double b) {
  const double c = 1 - a - b;
  GaussPoint out{Eigen::VectorXd(3), Eigen::VectorXd(3), Eigen::VectorXd(3), 1.0 / 6};
  if (!quadratic) {
    out.value << c, a, b;
    out.slope_a << -1, 1, 0;
    out.slope_b << -1, 0, 1;
    return out;
  }
  for (Eigen::VectorXd* v : {&out.value, &out.slope_a, &out.slope_b}) v->resize(6);
  out.value << c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * c * a, 4 * a * b, 4 * b * c;
  out.slope_a << 1 - 4 * c, 4 * a - 1, 0, 4 * (c - a), 4 * b, -4 * b;
  out.slope_b << 1 - 4 * c, 0, 4 * b - 1, -4 * a, 4 * a, 4 * (c - b);
  return out;
}

std::vector<GaussPoint> calc_gauss_points(ElementType type) {
  std::vector<GaussPoint> points;
  if (type == ElementType::kQuad4 || type == ElementType::kQuad8) {
    const double g = 1 / std::sqrt(3.0);
    for (const double b : {-g, g})
      for (const double a : {-g, g}) points.push_back(calc_quad(type == ElementType::kQuad8, a, b));
  } else {
    constexpr double kNear = 1.0 / 6, kFar = 2.0 / 3;
    for (const auto& [a, b] : {std::pair{kNear, kNear}, {kFar, kNear}, {kNear, kFar}})
      points.push_back(calc_triangle(type == ElementType::kTriangle6, a, b));
  }
  return points;
}

Vector3d interpolate(const std::vector<Vector3d>& at_nodes, const Element& element, const Eigen::VectorXd& weights) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < element.nodes.size(); ++i)
    sum += weights[static_cast<Eigen::Index>(i)] * at_nodes[static_cast<std::size_t>(element.nodes[i])];
  return sum;
}

using Shapes = std::vector<std::vector<Vector3d>>;  // of each mode, at each node

void add_points(const Mesh& mesh, const Shapes& shapes, double surface_density, std::vector<hil::ModalPoint>& points) {
  for (const Element& element : mesh.elements)
    for (const GaussPoint& gauss : calc_gauss_points(element.type)) {
      const Vector3d along_a = interpolate(mesh.nodes, element, gauss.slope_a);
      const Vector3d along_b = interpolate(mesh.nodes, element, gauss.slope_b);
      hil::ModalPoint point;
      point.mass = surface_density * gauss.weight * along_a.cross(along_b).norm();
      point.position = interpolate(mesh.nodes, element, gauss.value);
      point.shape.resize(3, static_cast<Eigen::Index>(shapes.size()));
      for (std::size_t k = 0; k < shapes.size(); ++k)
        point.shape.col(static_cast<Eigen::Index>(k)) = interpolate(shapes[k], element, gauss.value);
      points.push_back(std::move(point));
    }
}

// The displacement is the node's. The rotation is that of the rigid motion about it which comes closest to the
// displacements of all nodes of its elements: shells write no rotations.
hil::ModalMarker build_marker(const Mesh& mesh, const Shapes& shapes, const MarkerRequest& request) {
  const auto nearest =
      std::min_element(mesh.nodes.begin(), mesh.nodes.end(), [&](const Vector3d& a, const Vector3d& b) {
        return (a - request.position).squaredNorm() < (b - request.position).squaredNorm();
      });
  const int node = static_cast<int>(nearest - mesh.nodes.begin());
  std::set<int> around;
  for (const Element& element : mesh.elements)
    if (std::count(element.nodes.begin(), element.nodes.end(), node) > 0)
      around.insert(element.nodes.begin(), element.nodes.end());
  hil::ModalMarker marker;
  marker.name = request.name;
  marker.position = *nearest;
  marker.shape.resize(3, static_cast<Eigen::Index>(shapes.size()));
  marker.rotation.resize(3, static_cast<Eigen::Index>(shapes.size()));
  Matrix3d spread = Matrix3d::Zero();
  for (const int other : around) {
    const Vector3d r = mesh.nodes[static_cast<std::size_t>(other)] - *nearest;
    spread += r.squaredNorm() * Matrix3d::Identity() - r * r.transpose();
  }
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const Vector3d base = shapes[k][static_cast<std::size_t>(node)];
    Vector3d turn = Vector3d::Zero();
    for (const int other : around) {
      const auto i = static_cast<std::size_t>(other);
      turn += (mesh.nodes[i] - *nearest).cross(shapes[k][i] - base);
    }
    marker.shape.col(static_cast<Eigen::Index>(k)) = base;
    marker.rotation.col(static_cast<Eigen::Index>(k)) = spread.ldlt().solve(turn);
  }
  return marker;
}

// To `digits` behind the first of the largest. Divided, not multiplied, by a power of ten the result prints short.
template <typename Values>
void round_to(int digits, double largest, Values&& values) {
  if (!(largest > 0)) return;
  const double scale = std::pow(10, std::max(0.0, digits - std::floor(std::log10(largest))));
  values = values.unaryExpr([scale](double x) { return std::round(x * scale) / scale; }).eval();
}

void round_all(int digits, hil::Modes& modes) {
  double mass = 0, size = 0;
  for (const hil::ModalPoint& point : modes.points) {
    mass = std::max(mass, point.mass);
    size = std::max(size, point.position.cwiseAbs().maxCoeff());
  }
  for (hil::ModalPoint& point : modes.points) {
    round_to(digits, mass, Eigen::Map<Eigen::Matrix<double, 1, 1>>(&point.mass));
    round_to(digits, size, point.position);
  }
  for (Eigen::Index k = 0; k < modes.get_count(); ++k) {
    double largest = 0;
    for (const hil::ModalPoint& point : modes.points)
      largest = std::max(largest, point.shape.col(k).cwiseAbs().maxCoeff());
    for (hil::ModalPoint& point : modes.points) round_to(digits, largest, point.shape.col(k));
  }
}

}  // namespace

hil::Modes build_modes(const MeshModes& found, double surface_density, double rigid_hz, int count, int digits,
                       const std::vector<MarkerRequest>& markers) {
  hil::Modes modes;
  Shapes shapes;
  std::vector<double> frequencies_hz;
  for (std::size_t k = 0; k < found.frequencies_hz.size(); ++k) {
    if (found.frequencies_hz[k] < rigid_hz || (count > 0 && static_cast<int>(shapes.size()) == count)) continue;
    shapes.push_back(found.displacements[k]);
    frequencies_hz.push_back(found.frequencies_hz[k]);
  }
  if (shapes.empty()) throw std::invalid_argument("there are no elastic modes");
  modes.frequencies_hz = Eigen::Map<Eigen::VectorXd>(frequencies_hz.data(), static_cast<Eigen::Index>(shapes.size()));
  modes.source = {found.program + ", " + hil::count(found.mesh.nodes.size(), "node") + ", " +
                  hil::count(found.mesh.elements.size(), "shell element") + "; masses at Gauss points"};
  add_points(found.mesh, shapes, surface_density, modes.points);
  for (const MarkerRequest& request : markers) modes.markers.push_back(build_marker(found.mesh, shapes, request));
  round_all(digits, modes);
  return modes;
}

}  // namespace unlatch::tools
