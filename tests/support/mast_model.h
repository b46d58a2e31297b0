// A scissor mast: units of two bars that a hinge crosses in their middles, hinged to the next unit at both ends. Planar
// in space, so that each loop of four bars has three redundant rows.
#pragma once

#include <cmath>
#include <string>

#include "unlatch/model.h"

namespace unlatch::test {

// Bars of 2 m in the plane z = 0 along x, each at `angle` (rad) from it; body 2 i and 2 i + 1 are the bars of unit i.
// The first bar turns about its middle on the ground. Every joint has the modes hinge, weld and free.
inline Model build_mast(int units, double angle = 1) {
  constexpr double kHalf = 1;  // m
  constexpr RowSet kHinge = row_bit(kX) | row_bit(kY) | row_bit(kZ) | row_bit(kRotX) | row_bit(kRotY);
  constexpr RowSet kWeld = kHinge | row_bit(kRotZ);
  Model model;
  model.name = "mast";
  model.gravity.uniform = {0, -1, 0};
  for (int i = 0; i < units; ++i)
    for (const int side : {1, -1}) {
      Body bar;
      bar.name = (side > 0 ? "a" : "b") + std::to_string(i);
      bar.mass = 1;
      bar.inertia = Eigen::Vector3d(0.01, 0.33, 0.33).asDiagonal();
      bar.p_WB = {2 * kHalf * std::cos(angle) * i, 0, 0};
      bar.q_WB = Eigen::AngleAxisd(side * angle, Eigen::Vector3d::UnitZ());
      model.bodies.push_back(bar);
    }
  const auto add = [&](const std::string& name, int base, int follower, double at_base, double at_follower) {
    Joint joint;
    joint.name = name;
    joint.base = base;
    joint.follower = follower;
    joint.point_base = {at_base, 0, 0};
    joint.point_follower = {at_follower, 0, 0};
    joint.modes = {{"hinge", kHinge}, {"weld", kWeld}, {"free", 0}};
    model.joints.push_back(joint);
  };
  add("base", kGround, 0, 0, 0);
  for (int i = 0; i < units; ++i) {
    const std::string number = std::to_string(i);
    add("cross" + number, 2 * i, 2 * i + 1, 0, 0);
    if (i + 1 == units) break;
    add("upper" + number, 2 * i, 2 * i + 3, kHalf, -kHalf);
    add("lower" + number, 2 * i + 1, 2 * i + 2, kHalf, -kHalf);
  }
  return model;
}

}  // namespace unlatch::test
