// The systems on which solvers are compared: n bodies in a tree, the root free, every joint a revolute one, with random
// masses, hinges, attitudes and speeds, under gravity.
#pragma once

#include <cstddef>
#include <vector>

#include "kernel/model.h"

namespace unlatch::bench {

enum class Shape { kStar, kChain, kBintree };
inline constexpr Shape kShapes[] = {Shape::kStar, Shape::kChain, Shape::kBintree};
const char* get_name(Shape shape);

inline constexpr int kHingeRows = 5;  // x, y, z, rot_x, rot_y: every joint turns about its z

// Body 0 is the root; joint k − 1 has body k as its follower, and a base that comes before it. The frames of each joint
// coincide, so that all angles are zero, and all rows hold in position and velocity.
Model build_solve_model(Shape shape, int n);

// One acceleration solve's answer.
struct Solution {
  std::vector<double> accelerations;  // the root's (linear, angular; world axes), then each hinge's; m/s², rad/s²
  std::vector<double> multipliers;    // kHingeRows a joint, N and N m; empty where the solver has none
};

// `body_accelerations`: linear and angular per body, world axes, at the centres of mass.
std::vector<double> calc_coordinates(const Model& model, const std::vector<double>& body_accelerations);

}  // namespace unlatch::bench
