#include "hil/analysis/clearance.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <stdexcept>
#include <string>

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

// FCL's shapes with an axis are centred, along z.
Eigen::Isometry3d calc_axis_pose(const Shape& shape) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translate(0.5 * (shape.from + shape.to));
  X.rotate(Eigen::Quaterniond::FromTwoVectors(Vector::UnitZ(), shape.to - shape.from));
  return X;
}

// GJK needs the points alone: without faces FCL searches all of them, and points inside the hull do no harm.
std::shared_ptr<fcl::CollisionGeometryd> build_hull(const std::vector<Vector>& points) {
  return std::make_shared<fcl::Convexd>(std::make_shared<const std::vector<Vector>>(points), 0,
                                        std::make_shared<const std::vector<int>>());
}

struct Piece {
  Shape shape;
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
};

Piece build_piece(const Shape& shape) {
  Piece piece{shape, nullptr, Eigen::Isometry3d::Identity()};
  const double length = (shape.to - shape.from).norm();
  switch (shape.kind) {
    case Shape::Kind::kSphere:
      piece.geometry = std::make_shared<fcl::Sphered>(shape.radius);
      piece.X_BS.translate(shape.from);
      return piece;
    case Shape::Kind::kCapsule:
      piece.geometry = std::make_shared<fcl::Capsuled>(shape.radius, length);
      break;
    case Shape::Kind::kCylinder:
      piece.geometry = std::make_shared<fcl::Cylinderd>(shape.radius, length);
      break;
    case Shape::Kind::kCone:
      piece.geometry = std::make_shared<fcl::Coned>(shape.radius, length);
      break;
    case Shape::Kind::kBox:
      piece.geometry = std::make_shared<fcl::Boxd>(shape.size);
      piece.X_BS.translate(shape.from);
      piece.X_BS.rotate(shape.q_BS);
      return piece;
    case Shape::Kind::kHull:
      piece.geometry = build_hull(shape.points);
      return piece;
  }
  piece.X_BS = calc_axis_pose(shape);
  return piece;
}

// Debian's FCL was built with Eigen's vectors, which want 16-byte alignment; this project builds without them, and
// Eigen then aligns nothing. Only transforms cross the border.
struct alignas(16) AlignedPose {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
};
static_assert(sizeof(Eigen::Isometry3d) == 16 * sizeof(double));

AlignedPose calc_piece_pose(const Piece& piece, const Pose& body) {
  AlignedPose pose;
  pose.X.translate(body.p_WB);
  pose.X.rotate(body.q_WB.normalized());
  pose.X = pose.X * piece.X_BS;
  return pose;
}

double calc_distance(const Piece& a, const Pose& at_a, const Piece& b, const Pose& at_b) {
  if (is_round(a.shape) && is_round(b.shape)) return calc_round_distance(a.shape, at_a, b.shape, at_b);
  fcl::DistanceRequestd request;
  request.enable_signed_distance = false;
  request.distance_tolerance = 1e-7;
  request.gjk_solver_type = fcl::GST_LIBCCD;
  const AlignedPose X_a = calc_piece_pose(a, at_a), X_b = calc_piece_pose(b, at_b);
  fcl::DistanceResultd result;
  fcl::distance(a.geometry.get(), X_a.X, b.geometry.get(), X_b.X, request, result);
  return std::max(0.0, result.min_distance);
}

}  // namespace

struct ClearanceMonitor::Geometry {
  std::vector<std::vector<Piece>> bodies;
};

ClearanceMonitor::ClearanceMonitor(const std::vector<std::pair<int, int>>& pairs,
                                   const std::vector<std::vector<Shape>>& shapes)
    : geometry_(std::make_unique<Geometry>()) {
  for (const std::vector<Shape>& list : shapes) {
    std::vector<Piece>& pieces = geometry_->bodies.emplace_back();
    for (const Shape& shape : list) pieces.push_back(build_piece(shape));
  }
  for (const auto& [a, b] : pairs) {
    for (const int body : {a, b})
      if (body < 0 || static_cast<std::size_t>(body) >= shapes.size() || shapes[static_cast<std::size_t>(body)].empty())
        throw std::invalid_argument("clearance: body " + std::to_string(body) + " has no shape");
    clearances_.push_back({.a = a, .b = b});
  }
}

ClearanceMonitor::~ClearanceMonitor() = default;
ClearanceMonitor::ClearanceMonitor(ClearanceMonitor&&) noexcept = default;
ClearanceMonitor& ClearanceMonitor::operator=(ClearanceMonitor&&) noexcept = default;

void ClearanceMonitor::update(double time, const std::vector<Pose>& poses) {
  for (Clearance& clearance : clearances_) {
    const auto a = static_cast<std::size_t>(clearance.a), b = static_cast<std::size_t>(clearance.b);
    clearance.now = std::numeric_limits<double>::infinity();
    for (const Piece& piece_a : geometry_->bodies[a])
      for (const Piece& piece_b : geometry_->bodies[b])
        clearance.now = std::min(clearance.now, calc_distance(piece_a, poses.at(a), piece_b, poses.at(b)));
    if (clearance.now < clearance.smallest) {
      clearance.smallest = clearance.now;
      clearance.time = time;
    }
  }
}

}  // namespace unlatch::hil
