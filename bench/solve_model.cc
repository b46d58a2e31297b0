#include "bench/solve_model.h"

#include <string>

#include "tests/support/random.h"

namespace unlatch::bench {
namespace {

using test::Random;

constexpr std::uint64_t kSeed = 1;

int get_parent(Shape shape, int body) {
  switch (shape) {
    case Shape::kStar:
      return 0;
    case Shape::kChain:
      return body - 1;
    case Shape::kBintree:
      return (body - 1) / 2;
  }
  return 0;
}

Eigen::Vector3d draw_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

Eigen::Quaterniond draw_attitude(Random& random) {
  Eigen::Quaterniond q(random.uniform(0.1, 1), random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  return q.normalized();
}

Body draw_body(Random& random, int index) {
  Body body;
  body.name = "body" + std::to_string(index);
  body.mass = random.uniform(1, 3);
  // Moments of three pairs of masses on the axes satisfy every inequality of inertias.
  const Eigen::Vector3d p(random.uniform(0.1, 0.3), random.uniform(0.1, 0.3), random.uniform(0.1, 0.3));
  const Eigen::Matrix3d axes = draw_attitude(random).toRotationMatrix();
  body.inertia = axes * Eigen::Vector3d(p.y() + p.z(), p.x() + p.z(), p.x() + p.y()).asDiagonal() * axes.transpose();
  body.inertia = (0.5 * (body.inertia + body.inertia.transpose())).eval();
  body.q_WB = draw_attitude(random);
  return body;
}

Joint draw_hinge(Random& random, int base, int follower) {
  Joint joint;
  joint.name = "hinge" + std::to_string(follower);
  joint.base = base;
  joint.follower = follower;
  joint.point_base = draw_vector(random, 0.5);
  joint.point_follower = draw_vector(random, 0.5);
  joint.axes = draw_attitude(random).toRotationMatrix();
  joint.modes = {{"hinge", kPointRows | row_bit(kRotX) | row_bit(kRotY)}};
  return joint;
}

// Puts the follower where the hinge wants it, turning about it with `speed`, rad/s.
void close(const Joint& joint, const Body& base, double speed, Body& follower) {
  const Eigen::Matrix3d R_base = base.q_WB.toRotationMatrix(), R_follower = follower.q_WB.toRotationMatrix();
  const Eigen::Vector3d w_base = R_base * base.w_WB_B;
  const Eigen::Vector3d w = w_base + speed * (R_base * joint.axes.col(2));
  const Eigen::Vector3d arm_base = R_base * joint.point_base, arm = R_follower * joint.point_follower;
  follower.p_WB = base.p_WB + arm_base - arm;
  follower.w_WB_B = R_follower.transpose() * w;
  follower.v_WB = base.v_WB + w_base.cross(arm_base) - w.cross(arm);
}

}  // namespace

const char* get_name(Shape shape) {
  switch (shape) {
    case Shape::kStar:
      return "star";
    case Shape::kChain:
      return "chain";
    case Shape::kBintree:
      return "bintree";
  }
  return "";
}

Model build_solve_model(Shape shape, int n) {
  Random random(kSeed);
  Model model;
  model.name = get_name(shape);
  model.gravity.uniform = {0, 0, -9.81};
  model.bodies.push_back(draw_body(random, 0));
  model.bodies[0].v_WB = draw_vector(random, 1);
  model.bodies[0].w_WB_B = draw_vector(random, 1);
  for (int k = 1; k < n; ++k) {
    const int parent = get_parent(shape, k);
    model.joints.push_back(draw_hinge(random, parent, k));
    model.bodies.push_back(draw_body(random, k));
    close(model.joints.back(), model.bodies[static_cast<std::size_t>(parent)], random.uniform(-1, 1),
          model.bodies.back());
  }
  return model;
}

std::vector<double> calc_coordinates(const Model& model, const std::vector<double>& body_accelerations) {
  const auto angular = [&](int body) {
    return Eigen::Vector3d::Map(&body_accelerations[6 * static_cast<std::size_t>(body) + 3]);
  };
  std::vector<double> out(body_accelerations.begin(), body_accelerations.begin() + 6);
  for (const Joint& joint : model.joints) {
    // w_follower = w_base + z q', and z' = w_base × z has no part along z.
    const Eigen::Vector3d z = model.bodies[static_cast<std::size_t>(joint.base)].q_WB * joint.axes.col(2);
    out.push_back(z.dot(angular(joint.follower) - angular(joint.base)));
  }
  return out;
}

}  // namespace unlatch::bench
