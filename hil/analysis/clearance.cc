#include "hil/analysis/clearance.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

#include "hil/analysis/convex_distance.h"
#include "hil/modules/module.h"

namespace unlatch::hil {
namespace {

using Vector = Eigen::Vector3d;

bool is_round(const Shape& shape) { return shape.kind == Shape::Kind::kSphere || shape.kind == Shape::Kind::kCapsule; }

// Closest approach of the segments p + s·u and q + t·v, s and t in [0, 1]: minimise over the line, clamp, and minimise
// the other parameter again (Ericson, Real-Time Collision Detection, 2005, 5.1.9). Degenerate segments are points.
double calc_segment_distance(const Vector& p, const Vector& u, const Vector& q, const Vector& v) {
  const Vector r = p - q;
  const double a = u.squaredNorm(), e = v.squaredNorm(), f = v.dot(r), c = u.dot(r), b = u.dot(v);
  double s = 0, t = 0;
  if (a > 0 && e > 0) {
    const double determinant = a * e - b * b;
    constexpr double kParallel = 1e-14;  // relative: below, any point of the overlap is as near
    s = determinant > kParallel * a * e ? std::clamp((b * f - c * e) / determinant, 0.0, 1.0) : 0.0;
    t = (b * s + f) / e;
    if (t < 0 || t > 1) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((b * t - c) / a, 0.0, 1.0);
    }
  } else if (e > 0) {
    t = std::clamp(f / e, 0.0, 1.0);
  } else if (a > 0) {
    s = std::clamp(-c / a, 0.0, 1.0);
  }
  return (r + s * u - t * v).norm();
}

double calc_round_distance(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b) {
  const auto axis = [](const Shape& s) {
    return s.kind == Shape::Kind::kCapsule ? Vector(s.to - s.from) : Vector::Zero();
  };
  const double between = calc_segment_distance(at_a.p_WB + at_a.q_WB * a.from, at_a.q_WB * axis(a),
                                               at_b.p_WB + at_b.q_WB * b.from, at_b.q_WB * axis(b));
  return std::max(0.0, between - a.radius - b.radius);
}

}  // namespace

std::unique_ptr<ConvexDistance> open_convex_distance() {
  return std::unique_ptr<ConvexDistance>(
      find_function<ConvexDistance*()>("unlatch-fcl", "unlatch_open_convex_distance")());
}

// Pieces that no closed form serves are known to `convex` by a number.
struct ClearanceMonitor::Geometry {
  struct Piece {
    Shape shape;
    std::optional<std::size_t> convex;
  };
  std::vector<std::vector<Piece>> bodies;
  std::unique_ptr<ConvexDistance> convex;  // null until a pair needs it

  void add_convex(Piece& piece) {
    if (!convex) convex = open_convex_distance();
    if (!piece.convex) piece.convex = convex->add(piece.shape);
  }

  double calc_distance(Piece& a, const Pose& at_a, Piece& b, const Pose& at_b) {
    if (is_round(a.shape) && is_round(b.shape)) return calc_round_distance(a.shape, at_a, b.shape, at_b);
    return convex->calc(*a.convex, at_a, *b.convex, at_b);
  }
};

ClearanceMonitor::ClearanceMonitor(const std::vector<std::pair<int, int>>& pairs,
                                   const std::vector<std::vector<Shape>>& shapes)
    : geometry_(std::make_unique<Geometry>()) {
  for (const std::vector<Shape>& list : shapes) {
    std::vector<Geometry::Piece>& pieces = geometry_->bodies.emplace_back();
    for (const Shape& shape : list) pieces.push_back({shape, {}});
  }
  for (const auto& [a, b] : pairs) {
    for (const int body : {a, b})
      if (body < 0 || static_cast<std::size_t>(body) >= shapes.size() || shapes[static_cast<std::size_t>(body)].empty())
        throw std::invalid_argument("clearance: body " + std::to_string(body) + " has no shape");
    clearances_.push_back({.a = a, .b = b});
    for (Geometry::Piece& piece_a : geometry_->bodies[static_cast<std::size_t>(a)]) {
      for (Geometry::Piece& piece_b : geometry_->bodies[static_cast<std::size_t>(b)]) {
        if (!is_round(piece_a.shape) || !is_round(piece_b.shape))
          geometry_->add_convex(piece_a), geometry_->add_convex(piece_b);
      }
    }
  }
}

ClearanceMonitor::~ClearanceMonitor() = default;
ClearanceMonitor::ClearanceMonitor(ClearanceMonitor&&) noexcept = default;
ClearanceMonitor& ClearanceMonitor::operator=(ClearanceMonitor&&) noexcept = default;

double ClearanceMonitor::calc(std::size_t pair, const Pose& a, const Pose& b) {
  double distance = std::numeric_limits<double>::infinity();
  for (Geometry::Piece& piece_a : geometry_->bodies[static_cast<std::size_t>(clearances_[pair].a)])
    for (Geometry::Piece& piece_b : geometry_->bodies[static_cast<std::size_t>(clearances_[pair].b)])
      distance = std::min(distance, geometry_->calc_distance(piece_a, a, piece_b, b));
  return distance;
}

bool ClearanceMonitor::is_exact(std::size_t pair) const {
  const auto are_round = [&](int body) {
    const std::vector<Geometry::Piece>& pieces = geometry_->bodies[static_cast<std::size_t>(body)];
    return std::all_of(pieces.begin(), pieces.end(),
                       [](const Geometry::Piece& piece) { return is_round(piece.shape); });
  };
  return are_round(clearances_[pair].a) && are_round(clearances_[pair].b);
}

void ClearanceMonitor::update(double time, const std::vector<Pose>& poses) {
  for (std::size_t i = 0; i < clearances_.size(); ++i) {
    Clearance& clearance = clearances_[i];
    clearance.now =
        calc(i, poses.at(static_cast<std::size_t>(clearance.a)), poses.at(static_cast<std::size_t>(clearance.b)));
    if (clearance.now < clearance.smallest) {
      clearance.smallest = clearance.now;
      clearance.time = time;
    }
  }
}

}  // namespace unlatch::hil
