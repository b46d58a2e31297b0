#include "tests/support/tree_links.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <stdexcept>

#include "tests/support/linear_algebra.h"

namespace unlatch::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Rates along axes that may be oblique.
std::vector<double> calc_speeds(const std::vector<Vector3d>& axes, const Vector3d& motion) {
  if (axes.empty()) return {};
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(axes.size()));
  for (std::size_t k = 0; k < axes.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = axes[k];
  const Eigen::VectorXd speeds = solve_least_squares(columns, motion);
  return {speeds.begin(), speeds.end()};
}

// Axis y of the follower's rotation frame; the frames coincide at the start if only the base's is given.
Vector3d calc_follower_y(const Joint& joint, const Placement& base, const Placement& follower) {
  if (joint.follower_axes) return follower.R * joint.follower_axes->col(1);
  return base.R * joint.rotation_axes.value_or(joint.axes).col(1);
}

}  // namespace

std::vector<int> list_closing_joints(const Model& model) {
  std::vector<int> group(model.bodies.size() + 1), closing;  // the last is the ground
  for (std::size_t b = 0; b < group.size(); ++b) group[b] = static_cast<int>(b);
  const auto find = [&](int body) {
    int g = body == kGround ? static_cast<int>(model.bodies.size()) : body;
    while (group[at(g)] != g) g = group[at(g)] = group[at(group[at(g)])];
    return g;
  };
  for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
    const int base = find(model.joints[at(j)].base), follower = find(model.joints[at(j)].follower);
    if (base == follower)
      closing.push_back(j);
    else
      group[at(follower)] = base;
  }
  return closing;
}

ClosingJoint get_closing_joint(const Model& model, int j) {
  const Joint& joint = model.joints[at(j)];
  const Freedoms f = calc_freedoms(model, joint);
  if (!f.slides.empty() || f.turns.size() > 1)
    throw std::invalid_argument("joint '" + joint.name + "' closes a loop and is neither a hinge nor a weld");
  ClosingJoint out{joint.base, joint.follower, f.turns.empty(), f.point, Matrix3d::Identity()};
  if (out.weld) return out;
  const Vector3d z = f.turns[0], x = z.unitOrthogonal();
  out.hinge << x, z.cross(x), z;
  return out;
}

std::vector<TreeLink> build_tree_links(const Model& model) {
  std::vector<std::vector<int>> joints(model.bodies.size());
  std::vector<bool> closes(model.joints.size(), false);
  for (const int j : list_closing_joints(model)) closes[at(j)] = true;
  std::vector<TreeLink> links;
  for (int j = 0; j < static_cast<int>(model.joints.size()); ++j) {
    const Joint& joint = model.joints[at(j)];
    if (closes[at(j)]) continue;
    if (joint.base == kGround) {
      links.push_back({joint.follower, kGround, j, true});
      continue;
    }
    joints[at(joint.base)].push_back(j);
    joints[at(joint.follower)].push_back(j);
  }
  if (links.empty()) links.push_back({0, kGround, kNone, true});
  for (std::size_t k = 0; k < links.size() && k < model.bodies.size(); ++k) {
    const TreeLink link = links[k];
    for (const int j : joints[at(link.body)]) {
      if (j == link.joint) continue;
      const Joint& joint = model.joints[at(j)];
      const bool forward = joint.base == link.body;
      links.push_back({forward ? joint.follower : joint.base, link.body, j, forward});
    }
  }
  if (links.size() != model.bodies.size())
    throw std::invalid_argument("model '" + model.name + "' does not hang together");
  return links;
}

Placement get_placement(const Model& model, int body) {
  if (body == kGround) return {};
  const Body& b = model.bodies[at(body)];
  const Matrix3d R = b.q_WB.normalized().toRotationMatrix();
  return {R, b.p_WB, b.v_WB, R * b.w_WB_B};
}

Freedoms calc_freedoms(const Model& model, const Joint& joint) {
  const Placement base = get_placement(model, joint.base), follower = get_placement(model, joint.follower);
  const RowSet rows = joint.modes[at(joint.mode)].rows;
  const Matrix3d n = base.R * joint.axes, m = base.R * joint.rotation_axes.value_or(joint.axes);
  const bool universal = joint.universal && (rows & kRotationRows) == row_bit(kRotZ);
  Freedoms f;
  const Vector3d arm = follower.R * joint.point_follower;
  f.point = follower.p + arm;
  for (int k = 0; k < 3; ++k) {
    if (!has_row(rows, kX + k)) {
      f.slides.push_back(n.col(k));
      f.slide_axes.push_back(k);
    }
    if (!has_row(rows, kRotX + k)) {
      f.turns.push_back(universal && k == 1 ? calc_follower_y(joint, base, follower) : Vector3d(m.col(k)));
      f.turn_axes.push_back(k);
    }
  }
  const Vector3d slip = follower.v + follower.w.cross(arm) - base.v - base.w.cross(f.point - base.p);
  f.slide_speeds = calc_speeds(f.slides, slip);
  f.turn_speeds = calc_speeds(f.turns, follower.w - base.w);
  return f;
}

std::vector<double> calc_joint_accelerations(const Model& model, const BodyAccelerations& bodies) {
  const auto point_acceleration = [&](int body, const Vector3d& point) -> Vector3d {
    if (body == kGround) return Vector3d::Zero();
    const Placement b = get_placement(model, body);
    const Vector3d arm = point - b.p;
    return bodies.linear[at(body)] + bodies.angular[at(body)].cross(arm) + b.w.cross(b.w.cross(arm));
  };
  const auto angular = [&](int body) -> Vector3d {
    return body == kGround ? Vector3d::Zero() : bodies.angular[at(body)];
  };
  std::vector<double> out;
  const TreeLink root = build_tree_links(model).front();
  if (root.joint == kNone) {
    out.insert(out.end(), bodies.linear[at(root.body)].begin(), bodies.linear[at(root.body)].end());
    out.insert(out.end(), bodies.angular[at(root.body)].begin(), bodies.angular[at(root.body)].end());
  }
  for (const Joint& joint : model.joints) {
    const Freedoms f = calc_freedoms(model, joint);
    const Vector3d slip = point_acceleration(joint.follower, f.point) - point_acceleration(joint.base, f.point);
    const Vector3d turn = angular(joint.follower) - angular(joint.base);
    for (const Vector3d& axis : f.slides) out.push_back(axis.dot(slip));
    for (const Vector3d& axis : f.turns) out.push_back(axis.dot(turn));
  }
  return out;
}

}  // namespace unlatch::test
