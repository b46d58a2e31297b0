// Joints of a model: their rows, and the modes that say which of these hold.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "unlatch/model/bodies.h"

namespace unlatch {

// The elementary rows of a joint: three point–plane rows (4.11), which hold the follower's point in the planes through
// the base's point normal to x, y, z of the joint frame; and three rotation rows (4.12) about the rotation frame's
// axes. The order is that of the multipliers.
enum Row : std::uint8_t { kX = 0, kY, kZ, kRotX, kRotY, kRotZ };
inline constexpr int kRows = 6;  // number of rows of a joint
using RowSet = std::uint8_t;     // bit r set: Row r is active
// The set of one row.
constexpr RowSet row_bit(int row) { return static_cast<RowSet>(1u << row); }
// `row` is in `set`.
constexpr bool has_row(RowSet set, int row) { return (set >> row & 1u) != 0; }
inline constexpr RowSet kPointRows = 0b000111;     // x, y, z
inline constexpr RowSet kRotationRows = 0b111000;  // rot_x, rot_y, rot_z
extern const char* const kRowNames[kRows];         // "x" … "rot_z"

// A mode of a joint.
struct JointMode {
  std::string name;  // unique within the joint
  RowSet rows = 0;   // active rows
};

// A joint between two bodies, or between the ground and a body. Its mode is the set of rows that hold; without rows it
// is free. A joint none of whose modes has rows constrains nothing: it serves to measure, or to carry springs.
struct Joint {
  std::string name;                                          // unique among joints
  int base = kGround;                                        // body i of (4.11): carries the joint frame
  int follower = 0;                                          // body j: carries the point
  Eigen::Vector3d point_base = Eigen::Vector3d::Zero();      // from base's origin, base axes (ground: W), m
  Eigen::Vector3d point_follower = Eigen::Vector3d::Zero();  // from follower's origin, follower axes, m
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();        // columns x, y, z of the joint frame in base axes
  std::optional<Eigen::Matrix3d> rotation_axes;  // frame of the rotation rows in base axes; the joint frame if absent
  std::optional<Eigen::Matrix3d> follower_axes;  // the rotation frame in follower axes at angle zero; if absent, the
                                                 // two coincide at the initial attitudes
  bool universal = false;  // in modes whose only rotation row is rot_z: that row is about x_base × y_follower, so that
                           // the follower may turn about x of the base and its own y
  std::vector<JointMode> modes;  // at least one
  int mode = 0;                  // initial mode
  // Stiffness of its point–plane rows beside those of other joints, > 0, for the split of redundant reactions alone
  // (kernel/solver/loops/redundant_rows.h). A rotation row shares as a point–plane row does at `share_length`, m, > 0;
  // by default a tenth of the distance of the joints of its loops from their middle, root mean square, at the start.
  double share = 1;
  std::optional<double> share_length{};  // see share
};

}  // namespace unlatch
