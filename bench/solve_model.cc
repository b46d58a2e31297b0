#include "bench/solve_model.h"

#include <cmath>
#include <string>

#include "tests/support/loop_models.h"
#include "tests/support/mast_model.h"
#include "tests/support/random.h"

namespace unlatch::bench {
namespace {

using test::Random;

constexpr std::uint64_t kSeed = 1;

int draw_parent(Random& random, Shape shape, int body) {
  switch (shape) {
    case Shape::kStar:
      return 0;
    case Shape::kChain:
    case Shape::kWeldedChain:
      return body - 1;
    case Shape::kBintree:
      return (body - 1) / 2;
    case Shape::kRandom:
      return random.below(body);
    default:
      break;
  }
  return 0;
}

constexpr RowSet kHinge = kPointRows | row_bit(kRotX) | row_bit(kRotY);
constexpr RowSet kWeld = kPointRows | kRotationRows;

struct Kind {
  const char* name;
  RowSet rows;
  bool universal = false;
};
constexpr Kind kKinds[] = {
    {"revolute", kHinge},
    {"prismatic", row_bit(kX) | row_bit(kY) | kRotationRows},
    {"ball", kPointRows},
    {"universal", kPointRows | row_bit(kRotZ), true},
    {"cylindrical", row_bit(kX) | row_bit(kY) | row_bit(kRotX) | row_bit(kRotY)},
    {"planar", row_bit(kZ) | row_bit(kRotX) | row_bit(kRotY)},
    {"weld", kWeld},
    {"revolute_slider", row_bit(kX) | row_bit(kY) | row_bit(kRotX) | row_bit(kRotZ)},
};

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

Joint draw_joint(Random& random, const Kind& kind, int base, int follower) {
  Joint joint;
  joint.name = "joint" + std::to_string(follower);
  joint.base = base;
  joint.follower = follower;
  joint.point_base = draw_vector(random, 0.5);
  joint.point_follower = draw_vector(random, 0.5);
  joint.axes = draw_attitude(random).toRotationMatrix();
  joint.universal = kind.universal;
  joint.modes = {{kind.name, kind.rows}};
  return joint;
}

// Places the follower as the joint requires, moving along each of its degrees of freedom with up to `speed`, m/s and
// rad/s.
void close(const Joint& joint, const Body& base, double speed, Random& random, Body& follower) {
  const Eigen::Matrix3d R_base = base.q_WB.toRotationMatrix(), R_follower = follower.q_WB.toRotationMatrix();
  const Eigen::Matrix3d axes = R_base * joint.axes;
  const Eigen::Vector3d w_base = R_base * base.w_WB_B;
  Eigen::Vector3d w = w_base, slip = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    if (!has_row(joint.modes[0].rows, kX + k)) slip += random.uniform(-speed, speed) * axes.col(k);
    if (!has_row(joint.modes[0].rows, kRotX + k)) w += random.uniform(-speed, speed) * axes.col(k);
  }
  const Eigen::Vector3d arm_base = R_base * joint.point_base, arm = R_follower * joint.point_follower;
  follower.p_WB = base.p_WB + arm_base - arm;
  follower.w_WB_B = R_follower.transpose() * w;
  follower.v_WB = base.v_WB + w_base.cross(arm_base) + slip - w.cross(arm);
}

// Joins both ends to the ground. The two joints come first and last, so that the tree hangs on the hinge and the weld
// closes the loop.
void hold_both_ends(Model& model, Random& random) {
  Joint hinge = draw_joint(random, {"hinge", kHinge}, kGround, 0);
  hinge.name = "root";
  hinge.point_base = model.bodies[0].q_WB * hinge.point_follower + model.bodies[0].p_WB;
  model.joints.insert(model.joints.begin(), hinge);
  const int tip = static_cast<int>(model.bodies.size()) - 1;
  const Body& body = model.bodies.back();
  Joint weld = draw_joint(random, {"weld", kWeld}, kGround, tip);
  weld.name = "tip";
  weld.point_base = body.q_WB * weld.point_follower + body.p_WB;
  model.joints.push_back(weld);
}

Model build_loops(Shape shape, int n) {
  const int side = static_cast<int>(std::sqrt(n / 2));
  switch (shape) {
    case Shape::kLadder:
      return test::build_ladder(n / 3);
    case Shape::kFourBars:
      return test::build_four_bars(n / 3);
    case Shape::kRing:
      return test::build_pantograph_ring(n / 4);
    case Shape::kTruss:
      return test::build_lattice(side, side);
    default:
      return test::build_mast(n / 2);
  }
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
    case Shape::kRandom:
      return "random";
    case Shape::kWeldedChain:
      return "welded_chain";
    case Shape::kMast:
      return "mast";
    case Shape::kLadder:
      return "ladder";
    case Shape::kFourBars:
      return "four_bars";
    case Shape::kRing:
      return "ring";
    case Shape::kTruss:
      return "truss";
  }
  return "";
}

Model build_solve_model(Shape shape, int n) {
  if (has_many_loops(shape)) return build_loops(shape, n);
  Random random(kSeed);
  Model model;
  model.name = get_name(shape);
  model.gravity.uniform = {0, 0, -9.81};
  model.bodies.push_back(draw_body(random, 0));
  const double speed = shape == Shape::kWeldedChain ? 0 : 1;  // fixed at both ends, it hangs at rest
  model.bodies[0].v_WB = speed * draw_vector(random, 1);
  model.bodies[0].w_WB_B = speed * draw_vector(random, 1);
  for (int k = 1; k < n; ++k) {
    const int parent = draw_parent(random, shape, k);
    const Kind& kind = shape == Shape::kRandom ? kKinds[random.below(static_cast<int>(std::size(kKinds)))] : kKinds[0];
    model.joints.push_back(draw_joint(random, kind, parent, k));
    model.bodies.push_back(draw_body(random, k));
    close(model.joints.back(), model.bodies[static_cast<std::size_t>(parent)], speed, random, model.bodies.back());
  }
  if (shape == Shape::kWeldedChain) hold_both_ends(model, random);
  return model;
}

}  // namespace unlatch::bench
