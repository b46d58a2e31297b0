#include "tests/support/random_model.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/random.h"
#include "unlatch/elementary.h"

namespace unlatch::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Shape = RandomModelOptions::Shape;

struct Kind {
  const char* name;
  RowSet rows;
  bool universal = false;
};
constexpr RowSet kAllRows = kPointRows | kRotationRows;
constexpr Kind kKinds[] = {
    {"revolute", kPointRows | row_bit(kRotX) | row_bit(kRotY)},
    {"prismatic", row_bit(kX) | row_bit(kY) | kRotationRows},
    {"cylindrical", row_bit(kX) | row_bit(kY) | row_bit(kRotX) | row_bit(kRotY)},
    {"universal", kPointRows | row_bit(kRotZ), true},
    {"ball", kPointRows},
    {"planar", row_bit(kZ) | row_bit(kRotX) | row_bit(kRotY)},
    {"revolute_slider", row_bit(kX) | row_bit(kY) | row_bit(kRotX) | row_bit(kRotZ)},
    {"weld", kAllRows},
    // not available in every program
    {"free", 0},
    {"point_plane", row_bit(kX)},
    {"composed", 0},  // of rows drawn at random
};
constexpr int kCommonKinds = 8;

// A body while it is placed in the model; the ground is one as well.
struct Placed {
  Vector3d p = Vector3d::Zero(), v = Vector3d::Zero(), w = Vector3d::Zero();  // inertial axes
  Matrix3d C = Matrix3d::Identity();                                          // body to inertial
};

Vector3d random_vector(Random& random, double size) {
  const double x = random.uniform(-size, size), y = random.uniform(-size, size), z = random.uniform(-size, size);
  return {x, y, z};
}

Matrix3d random_rotation(Random& random) {
  for (;;) {  // uniform: a point of the ball in four dimensions
    const Vector3d v = random_vector(random, 1);
    const Quaterniond q(random.uniform(-1, 1), v.x(), v.y(), v.z());
    if (q.norm() > 0.1 && q.norm() < 1) return q.normalized().toRotationMatrix();
  }
}

// Rotation by `angle` about a unit vector (Rodrigues).
Matrix3d build_rotation(double angle, const Vector3d& axis) {
  double sine, cosine;
  elementary::sincos(angle, sine, cosine);
  Matrix3d cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Matrix3d::Identity() + sine * cross + (1 - cosine) * cross * cross;
}

// Natural logarithm by Halley's iteration on the kernel's exponential, for 1e-20 < x < 1e20.
double calc_log(double x) {
  double log = 0;
  for (int i = 0; i < 40; ++i) {
    const double e = elementary::exp(log);
    log += 2 * (x - e) / (x + e);
  }
  return log;
}

// Draws a box of uniform density about a metre in size: its inertia obeys the triangle inequality and is
// well-conditioned.
Body random_body(Random& random, std::string name, double mass_ratio) {
  Body body;
  body.name = std::move(name);
  body.mass = elementary::exp(calc_log(mass_ratio) * random.uniform());
  const double a = random.uniform(0.5, 2), b = random.uniform(0.5, 2), c = random.uniform(0.5, 2);
  const Vector3d principal = body.mass / 12 * Vector3d(b * b + c * c, a * a + c * c, a * a + b * b);
  const Matrix3d axes = random_rotation(random);
  const Matrix3d inertia = axes * principal.asDiagonal() * axes.transpose();
  body.inertia = 0.5 * (inertia + inertia.transpose());
  return body;
}

// Draws modes: the kind first; then, in no fixed order, the modes that it may change to.
std::vector<JointMode> random_modes(Random& random, const Kind& kind) {
  std::vector<JointMode> modes = {{kind.name, kind.rows}};
  const auto part = static_cast<RowSet>(kind.rows & random.next() & kAllRows);
  const auto less_rotation = static_cast<RowSet>(kind.rows & kPointRows);
  const std::vector<JointMode> others = {
      {"part", part}, {"points", less_rotation}, {"released", 0}, {"latched", kAllRows}};
  const int first = random.below(4);
  for (int k = 0; k < 4; ++k) {
    const JointMode& mode = others[static_cast<std::size_t>((first + k) % 4)];
    if (k < 2 || random.chance(0.5)) modes.push_back(mode);
  }
  return modes;
}

// Joint coordinates and rates that the active rows allow.
struct Motion {
  Vector3d offset, offset_rate;  // r_j − r_i and its rate relative to the base, joint frame
  Matrix3d turn;                 // follower's rotation frame in the base's
  Vector3d turn_rate;            // of the follower relative to the base, base's rotation frame
};

// Draws coordinates. Rotation rows fix n·(w_j − w_i) with n of the base. Three hold the frames together, two leave a
// rotation about the third axis; one alone is non-holonomic and leaves any attitude. A universal joint turns about x of
// the base, then about y of the follower.
Motion random_motion(Random& random, const Joint& joint, bool follower_axes_given) {
  const RowSet rows = joint.modes[static_cast<std::size_t>(joint.mode)].rows;
  Motion motion;
  motion.offset = random_vector(random, 0.5);
  motion.offset_rate = random_vector(random, 0.5);
  motion.turn_rate = random_vector(random, 0.5);
  for (int k = 0; k < 3; ++k) {
    if (has_row(rows, kX + k)) motion.offset[k] = motion.offset_rate[k] = 0;
    if (has_row(rows, kRotX + k)) motion.turn_rate[k] = 0;
  }

  motion.turn = Matrix3d::Identity();
  if (joint.universal) {
    const Matrix3d about_x = build_rotation(random.uniform(-1, 1), Vector3d::UnitX());
    const Matrix3d about_y = build_rotation(random.uniform(-1, 1), Vector3d::UnitY());
    if ((rows & kRotationRows) == row_bit(kRotZ)) {
      if (follower_axes_given) motion.turn = about_x * about_y;
      const Vector3d own_y = motion.turn.col(1);
      motion.turn_rate = random.uniform(-0.5, 0.5) * Vector3d::UnitX();
      motion.turn_rate += random.uniform(-0.5, 0.5) * own_y;
      return motion;
    }
  }
  if (!follower_axes_given) return motion;
  Vector3d free_axis = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    if (!has_row(rows, kRotX + k)) free_axis[k] = 1;
  }
  const int freedoms = static_cast<int>(free_axis.sum());
  if (freedoms == 1) motion.turn = build_rotation(random.uniform(-2, 2), free_axis);
  if (freedoms > 1 && !joint.universal) motion.turn = random_rotation(random);
  return motion;
}

// Returns pose and velocity of the follower from those of the base, or the reverse.
//   C_j F = C_i R turn,         r_j = r_i + C_i A offset,
//   w_j = w_i + C_i R turn_rate,  r_j' − r_i' = C_i A offset_rate + w_i × (r_j − r_i)
Placed place(const Placed& known, bool known_is_base, const Joint& joint, const Matrix3d& follower_axes,
             const Motion& motion) {
  const Matrix3d axes = joint.rotation_axes.value_or(joint.axes);
  const Matrix3d turn = axes * motion.turn * follower_axes.transpose();  // C_iᵀ C_j
  Placed unknown;
  unknown.C = known_is_base ? Matrix3d(known.C * turn) : Matrix3d(known.C * turn.transpose());
  const Matrix3d& C_i = known_is_base ? known.C : unknown.C;
  const Matrix3d& C_j = known_is_base ? unknown.C : known.C;

  const double sign = known_is_base ? 1 : -1;
  unknown.w = known.w + sign * (C_i * axes * motion.turn_rate);
  const Vector3d& w_i = known_is_base ? known.w : unknown.w;
  const Vector3d& w_j = known_is_base ? unknown.w : known.w;

  const Vector3d arm_i = C_i * joint.point_base, arm_j = C_j * joint.point_follower;
  const Vector3d gap = C_i * joint.axes * motion.offset;
  const Vector3d gap_rate = C_i * joint.axes * motion.offset_rate + w_i.cross(gap);
  unknown.p = known.p + sign * (arm_i + gap - arm_j);
  unknown.v = known.v + sign * (w_i.cross(arm_i) + gap_rate - w_j.cross(arm_j));
  return unknown;
}

// Draws a joint between a body (or the ground) at a known place and one that the joint places.
Joint random_joint(Random& random, int known, int next, const RandomModelOptions& options,
                   std::vector<Placed>& placed) {
  Kind kind = kKinds[random.below(options.common_kinds ? kCommonKinds : static_cast<int>(std::size(kKinds)))];
  if (std::string_view(kind.name) == "composed") kind.rows = static_cast<RowSet>(random.next() & kAllRows);
  const bool known_is_base = known == kGround || random.chance(0.5);
  Joint joint;
  joint.base = known_is_base ? known : next;
  joint.follower = known_is_base ? next : known;
  joint.point_base = random_vector(random, 1);
  joint.point_follower = random_vector(random, 1);
  joint.axes = random_rotation(random);
  if (!options.common_kinds && random.chance(0.5)) joint.rotation_axes = random_rotation(random);
  joint.universal = kind.universal;
  joint.modes = random_modes(random, kind);
  if (!random.chance(options.first_mode_chance)) joint.mode = random.below(static_cast<int>(joint.modes.size()));

  const bool given = random.chance(0.5);
  const Matrix3d follower_axes = random_rotation(random);  // if left out: from the initial attitudes
  if (given) joint.follower_axes = follower_axes;
  const Motion motion = random_motion(random, joint, given);
  const Placed ground;
  placed[static_cast<std::size_t>(next)] = place(known == kGround ? ground : placed[static_cast<std::size_t>(known)],
                                                 known_is_base, joint, follower_axes, motion);
  return joint;
}

// Draws the parent of the k-th body (k ≥ 1), by rank in the order of placing.
int random_parent(Random& random, Shape shape, int k) {
  if (shape == Shape::kChain) return k - 1;
  if (shape == Shape::kStar) return 0;
  return random.below(k);
}

template <class T>
void shuffle(Random& random, std::vector<T>& items) {
  for (std::size_t k = items.size(); k > 1; --k)
    std::swap(items[k - 1], items[static_cast<std::size_t>(random.below(static_cast<int>(k)))]);
}

}  // namespace

Model build_random_model(std::uint64_t seed, const RandomModelOptions& options) {
  Random random(seed);
  const int count = options.bodies > 0 ? options.bodies : 1 + random.below(60);
  constexpr Shape kShapes[] = {Shape::kChain, Shape::kStar, Shape::kTree};
  const Shape shape = options.shape == Shape::kAny ? kShapes[random.below(3)] : options.shape;
  Model model;
  model.name = "random" + std::to_string(seed);
  for (int b = 0; b < count; ++b) {
    model.bodies.push_back(random_body(random, "body" + std::to_string(b), options.mass_ratio));
  }

  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  shuffle(random, order);
  std::vector<Placed> placed(static_cast<std::size_t>(count));
  if (random.chance(options.grounded_chance)) {
    model.joints.push_back(random_joint(random, kGround, order[0], options, placed));
  } else {
    placed[static_cast<std::size_t>(order[0])] = {random_vector(random, 5), random_vector(random, 1),
                                                  random_vector(random, 0.5), random_rotation(random)};
  }
  for (int k = 1; k < count; ++k) {
    const int parent = order[static_cast<std::size_t>(random_parent(random, shape, k))];
    model.joints.push_back(random_joint(random, parent, order[static_cast<std::size_t>(k)], options, placed));
  }
  shuffle(random, model.joints);
  for (std::size_t j = 0; j < model.joints.size(); ++j) model.joints[j].name = "joint" + std::to_string(j);

  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    model.bodies[b].p_WB = placed[b].p;
    model.bodies[b].q_WB = Quaterniond(placed[b].C).normalized();
    model.bodies[b].v_WB = placed[b].v;
    model.bodies[b].w_WB_B = placed[b].C.transpose() * placed[b].w;
  }
  return model;
}

Joint build_closing_joint(const Model& model, int base, int follower, Random& random) {
  const Body &b = model.bodies[static_cast<std::size_t>(base)], &f = model.bodies[static_cast<std::size_t>(follower)];
  Joint joint;
  joint.name = "loop" + std::to_string(model.joints.size());
  joint.base = base;
  joint.follower = follower;
  joint.point_base = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  const Eigen::Vector3d world = b.p_WB + b.q_WB.normalized() * joint.point_base;
  joint.point_follower = f.q_WB.normalized().conjugate() * (world - f.p_WB);
  return joint;
}

}  // namespace unlatch::test
