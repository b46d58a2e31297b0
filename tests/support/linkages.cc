#include "tests/support/linkages.h"

#include "tests/support/small_models.h"

namespace unlatch::test {
namespace {

// The shortest rotation from the x axis to a direction. Eigen's own takes a compiler twenty seconds: it has a singular
// value decomposition for opposite vectors.
Eigen::Quaterniond turn_x_to(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d to = direction.normalized();
  const Eigen::Quaterniond half(1 + to.x(), 0, -to.z(), to.y());  // w = 1 + x · to, vector part x × to
  return half.norm() > 0 ? half.normalized() : Eigen::Quaterniond(0, 0, 0, 1);
}

}  // namespace

Body build_rod(const std::string& name, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  Body rod = box(name, 1, 1e-3, 1.0 / 12, 1.0 / 12);
  rod.p_WB = 0.5 * (from + to);
  rod.q_WB = turn_x_to(to - from);
  return rod;
}

Joint build_hinge(const Model& model, int base, int follower, const Eigen::Vector3d& point,
                  const Eigen::Vector3d& axis) {
  const auto attitude = [&](int b) {
    return b == kGround ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                        : model.bodies[static_cast<std::size_t>(b)].q_WB.toRotationMatrix();
  };
  const auto position = [&](int b) {
    return b == kGround ? Eigen::Vector3d(0, 0, 0) : model.bodies[static_cast<std::size_t>(b)].p_WB;
  };
  Joint joint;
  joint.name = "hinge" + std::to_string(model.joints.size());
  joint.base = base;
  joint.follower = follower;
  joint.point_base = attitude(base).transpose() * (point - position(base));
  joint.point_follower = attitude(follower).transpose() * (point - position(follower));
  const Eigen::Vector3d x = axis.unitOrthogonal();
  Eigen::Matrix3d world;
  world << x, axis.cross(x), axis;
  joint.axes = attitude(base).transpose() * world;
  joint.modes = {{"hinge", kRevoluteRows}};
  return joint;
}

Model build_linkage(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& axes,
                    const Eigen::Vector3d& gravity) {
  Model model;
  model.gravity.uniform = gravity;
  const int rods = static_cast<int>(points.size()) - 1;
  for (int k = 0; k < rods; ++k) {
    const auto i = static_cast<std::size_t>(k);
    model.bodies.push_back(build_rod("rod" + std::to_string(k), points[i], points[i + 1]));
  }
  for (int k = 0; k <= rods; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const bool last = k == rods;
    model.joints.push_back(build_hinge(model, last ? kGround : k - 1, last ? k - 1 : k, points[i], axes[i]));
  }
  return model;
}

}  // namespace unlatch::test
