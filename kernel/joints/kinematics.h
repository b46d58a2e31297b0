// Frames of bodies and joints, one at a time, wherever they are kept.
#pragma once

#include "kernel/joints/joint_motion.h"
#include "kernel/plan/evaluation.h"

namespace unlatch {

// Frame of a body or of the ground, world axes, by the kinematics in `ev`.
BodyFrame get_body_frame(const Evaluation& ev, int body) noexcept;

// The same from states alone, whose angular velocities are in body axes.
inline BodyFrame calc_body_frame(const BodyState& body) noexcept {
  const Mat3 R = rotation_matrix(body.q);
  return {R, body.p, body.v, R * body.w};
}
inline BodyFrame calc_body_frame(const State& state, int body) noexcept {
  return body == kGround ? get_ground<double>() : calc_body_frame(state.bodies[at(body)]);
}

struct BodyKinematics {
  Mat3 R;  // R_WB
  Vec3 w;  // world axes, rad/s
  Sym3 J;  // about the origin, world axes, kg m²
};
BodyKinematics read_kinematics(const Evaluation& ev, int body) noexcept;

// The rows of a joint that hold now.
inline RowSet get_active_rows(const PlanData& plan, const State& state, int joint) noexcept {
  return plan.get_rows(joint, state.joints[at(joint)].mode);
}
// A universal joint's rotation frame follows its cross.
inline bool is_crossed(const PlanJoint& joint, RowSet rows) noexcept {
  return joint.universal && (rows & kRotationRows) == row_bit(kRotZ);
}
// True if the follower turns relative to the base about this axis of rotation alone, or about those of a cross: the
// rate of its angle is then the relative angular velocity along the axis.
inline bool has_plain_angle(const PlanJoint& joint, RowSet rows, int axis) noexcept {
  const auto others = static_cast<RowSet>(kRotationRows & static_cast<RowSet>(~row_bit(axis)));
  return (rows & others) == others || is_crossed(joint, rows);
}

// Parts of a joint's frame, as update_joints() leaves them: of an edge of the tree in its child's lane, of any other
// joint in a frame of its own.
class JointView {
 public:
  UNLATCH_INLINE JointView(const PlanData& plan, const Evaluation& ev, int joint)
      : plan_(plan),
        blocks_(ev.blocks.data()),
        joint_(plan.joints[at(joint)]),
        place_(joint_.non_tree == kNone ? ev.places[at(joint_.child)] : Place{}),
        frame_(joint_.non_tree == kNone ? nullptr : &ev.non_tree_frames[at(joint_.non_tree)]) {}

  // Axis of a row, world axes.
  UNLATCH_INLINE Vec3 get_axis(int row) const {
    if (frame_ != nullptr) return row < kRotX ? column(frame_->n, row) : column(frame_->m, row - kRotX);
    if (row < kRotX) return get_lane<SolverLane>(blocks_, place_).read_column(&SolverLane::axes, row);
    return LaneParts(plan_.groups[at(joint_.group)], blocks_, place_).axis(row).read();
  }
  UNLATCH_INLINE Mat3 get_rotation_axes() const {
    if (frame_ != nullptr) return frame_->m;
    return LaneParts(plan_.groups[at(joint_.group)], blocks_, place_).rotation_axes().read();
  }
  // v_rel, w_rel
  UNLATCH_INLINE Spatial get_slip() const {
    return frame_ != nullptr ? Spatial{frame_->v_rel, frame_->w_rel} : read(blocks_, place_, &JointLane::slip);
  }
  UNLATCH_INLINE Vec3 get_displacement() const {
    return frame_ != nullptr ? frame_->displacement : read(blocks_, place_, &JointLane::displacement);
  }
  UNLATCH_INLINE double get_displacement(int row) const {
    if (frame_ == nullptr) return get_lane<JointLane>(blocks_, place_).read_component(&JointLane::displacement, row);
    const Vec3& d = frame_->displacement;
    return row == kX ? d.x : (row == kY ? d.y : d.z);
  }
  // From a body's origin to the follower's point.
  UNLATCH_INLINE Vec3 get_arm(bool of_follower) const {
    if (frame_ != nullptr) return of_follower ? frame_->r_follower : frame_->r_base;
    const bool of_child = joint_.child == (of_follower ? joint_.follower : joint_.base);
    return of_child ? read(blocks_, place_, &SolverLane::arm_child) : read(blocks_, place_, &JointLane::arm_parent);
  }
  UNLATCH_INLINE const PlanJoint& get_joint() const { return joint_; }

 private:
  const PlanData& plan_;
  double* blocks_;
  const PlanJoint& joint_;
  Place place_;
  const JointFrame* frame_;
};

JointFrame get_joint_frame(const PlanData& plan, const State& state, const Evaluation& ev, int joint) noexcept;

// The rotation frame as the follower carries it, in world axes.
Mat3 calc_follower_axes(const PlanData& plan, const Evaluation& ev, int joint) noexcept;

// Size of three multipliers of a joint from row `first` on, N or N m; those of rows that do not hold are 0.
double calc_reaction_size(const Evaluation& ev, int joint, int first) noexcept;

// Relative attitude of a joint's rotation frame, follower to base.
Quat calc_relative_attitude(const PlanData& plan, const Evaluation& ev, int joint) noexcept;

}  // namespace unlatch
