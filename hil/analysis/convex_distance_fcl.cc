// Module unlatch-fcl: distances of convex shapes by FCL.
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>

#include "hil/analysis/convex_distance.h"

namespace unlatch::hil {
namespace {

using Vector = Eigen::Vector3d;

// The shortest turn from z to a unit vector. Eigen's FromTwoVectors would bring a singular value decomposition with it,
// for the one direction in which any turn by 180 degrees is as good.
Eigen::Quaterniond calc_turn_from_z(const Vector& to) {
  constexpr double kOpposite = 1e-12;
  if (to.z() < kOpposite - 1) return Eigen::Quaterniond(0, 1, 0, 0);
  const double s = std::sqrt(2 * (1 + to.z()));
  const Vector axis = Vector::UnitZ().cross(to) / s;
  return Eigen::Quaterniond(0.5 * s, axis.x(), axis.y(), axis.z());
}

// FCL's shapes with an axis are centred, along z.
Eigen::Isometry3d calc_axis_pose(const Shape& shape) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translate(0.5 * (shape.from + shape.to));
  X.rotate(calc_turn_from_z((shape.to - shape.from).normalized()));
  return X;
}

// GJK needs the points alone: without faces FCL searches all of them, and points inside the hull do no harm.
std::shared_ptr<fcl::CollisionGeometryd> build_hull(const std::vector<Vector>& points) {
  return std::make_shared<fcl::Convexd>(std::make_shared<const std::vector<Vector>>(points), 0,
                                        std::make_shared<const std::vector<int>>());
}

struct Piece {
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
};

Piece build_piece(const Shape& shape) {
  Piece piece;
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

class FclDistance final : public ConvexDistance {
 public:
  std::size_t add(const Shape& shape) override {
    pieces_.push_back(build_piece(shape));
    return pieces_.size() - 1;
  }

  double calc(std::size_t a, const Pose& at_a, std::size_t b, const Pose& at_b) override {
    fcl::DistanceRequestd request;
    request.enable_signed_distance = false;
    request.distance_tolerance = 1e-7;
    request.gjk_solver_type = fcl::GST_LIBCCD;
    const AlignedPose X_a = calc_piece_pose(pieces_[a], at_a), X_b = calc_piece_pose(pieces_[b], at_b);
    fcl::DistanceResultd result;
    fcl::distance(pieces_[a].geometry.get(), X_a.X, pieces_[b].geometry.get(), X_b.X, request, result);
    return std::max(0.0, result.min_distance);
  }

 private:
  std::vector<Piece> pieces_;
};

}  // namespace
}  // namespace unlatch::hil

extern "C" unlatch::hil::ConvexDistance* unlatch_open_convex_distance() { return new unlatch::hil::FclDistance; }
