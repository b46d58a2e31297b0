// Model of a tree in the form of programs with joint coordinates: bodies below their parents, and the degrees of
// freedom that each joint's rows leave, at the initial state. For the systems of MuJoCo and Simbody.
#pragma once

#include <vector>

#include "unlatch/model.h"

namespace unlatch::test {

struct TreeLink {
  int body, parent;        // parent: kGround for the root
  int joint;               // kNone for a root that is free
  bool child_is_follower;  // the child is the joint's follower
};
// Lists links, parents first. The roots are the bodies that are held to the ground, or body 0. Joints that close loops
// over those before them in the list are left out. Throws if the model does not hang together.
std::vector<TreeLink> build_tree_links(const Model& model);
// These joints, in the order of the list.
std::vector<int> list_closing_joints(const Model& model);

// A joint that closes a loop, at the initial state: one that holds the point and all rotations but, of a hinge, that
// about one axis. Throws std::invalid_argument for any other.
struct ClosingJoint {
  int base, follower;
  bool weld;
  Eigen::Vector3d point;  // W, m
  Eigen::Matrix3d hinge;  // W; its z: the axis of a hinge
};
ClosingJoint get_closing_joint(const Model& model, int joint);

// Position and motion of a body's frame, or of the ground's, in W.
struct Placement {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
};
Placement get_placement(const Model& model, int body);

// Degrees of freedom of a joint in its initial mode, follower relative to base. Axes are unit vectors in W.
struct Freedoms {
  Eigen::Vector3d point;                   // follower's point, W, m
  std::vector<Eigen::Vector3d> slides;     // fixed in the base
  std::vector<Eigen::Vector3d> turns;      // fixed in the base; two: x of the base, then y of the follower; three: any
  std::vector<int> slide_axes, turn_axes;  // indices of x, y, z
  std::vector<double> slide_speeds, turn_speeds;  // m/s, rad/s
};
Freedoms calc_freedoms(const Model& model, const Joint& joint);

// Accelerations at the bodies' centres of mass, W.
struct BodyAccelerations {
  std::vector<Eigen::Vector3d> linear, angular;  // m/s², rad/s²
};

// Quantities for comparing programs: the acceleration of a free root (linear, angular), then, joint by joint in the
// model's order, the relative acceleration of the two bodies along each degree of freedom.
std::vector<double> calc_joint_accelerations(const Model& model, const BodyAccelerations& bodies);

}  // namespace unlatch::test
