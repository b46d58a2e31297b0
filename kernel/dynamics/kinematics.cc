#include "kernel/dynamics/kinematics.h"

#include "kernel/dynamics/flexible.h"
#include "kernel/dynamics/rows.h"
#include "kernel/dynamics/varying.h"
#include "kernel/plan/lane_access.h"
#include "unlatch/elementary.h"

namespace unlatch {
namespace {

constexpr double kTwoPi = 6.283185307179586;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The value of `angle` + 2πk nearest to `previous`.
double unwind(double angle, double previous) { return angle - kTwoPi * std::nearbyint((angle - previous) / kTwoPi); }

// In its modes with rot_z as the only rotation row a universal joint's rotation frame follows the cross: x of the base,
// y of the follower, and their common normal, which the row is about.
Mat3 universal_frame(const Mat3& base, const Mat3& follower) {
  const Vec3 normal = cross(base.x, follower.y);
  const Vec3 z = (1.0 / norm(normal)) * normal;
  return {base.x, cross(z, base.x), z};
}

// Sine and cosine, times one number, of the turn by which the follower's pair of axes stands from the base's.
struct Turn {
  double sine, cosine;
};
UNLATCH_INLINE Turn calc_turn(const Vec3& bi, const Vec3& bj, const Vec3& fi, const Vec3& fj) {
  return {dot(bj, fi) - dot(bi, fj), dot(bi, fi) + dot(bj, fj)};
}

// The numbers of a joint's frame: an edge of the tree has them in its child's lane, any other joint in a frame.
struct JointNumbers {
  const PlanJoint& joint;
  const double* lanes;
  LaneSlot slot;
  const JointFrame* loose;

  UNLATCH_INLINE JointNumbers(const Plan& plan, const Workspace& ws, int j)
      : joint(plan.joints[at(j)]),
        lanes(ws.lanes.data()),
        slot(joint.loose == kNone ? ws.slots[at(joint.child)] : LaneSlot{}),
        loose(joint.loose == kNone ? nullptr : &ws.loose_frames[at(joint.loose)]) {}

  UNLATCH_INLINE Vec3 get_axis(int row) const {
    if (loose != nullptr) return row < kRotX ? column(loose->n, row) : column(loose->m, row - kRotX);
    return read_vec(lanes, slot, row < kRotX ? kAxes + 3 * row : joint.rotation_row + 3 * (row - kRotX));
  }
  UNLATCH_INLINE Vec3 get_slip(bool turning) const {
    if (loose != nullptr) return turning ? loose->w_rel : loose->v_rel;
    return read_vec(lanes, slot, turning ? kSlip + 3 : kSlip);
  }
};

// The turn about a rotation's axis, from the two axes of each side across it.
UNLATCH_INLINE Turn measure_turn(const Plan& plan, const State& state, const Workspace& ws, const PlanCoordinate& c,
                                 const JointNumbers& numbers) {
  const PlanJoint& j = numbers.joint;
  const Mat3 follower = read_mat(ws.lanes.data(), ws.slots[at(j.follower)], kRotation);
  const Vec3 fi = follower * c.across_follower[0], fj = follower * c.across_follower[1];
  if (!j.universal || !is_crossed(j, get_active_rows(plan, state, c.joint))) {
    const int k = c.row - kRotX;
    const int first = k == 2 ? 0 : k + 1, second = k == 0 ? 2 : k - 1;
    return calc_turn(numbers.get_axis(kRotX + first), numbers.get_axis(kRotX + second), fi, fj);
  }
  const Mat3 base = get_body_frame(ws, j.base).R;  // the cross has turned the joint's own
  return calc_turn(base * c.across_base[0], base * c.across_base[1], fi, fj);
}

// The sines of the turns that are read become angles, all at once.
void turn_into_angles(const Plan& plan, std::size_t count, Workspace& ws) {
  constexpr std::size_t kWidest = 8;
  for (std::size_t i = count; i % kWidest != 0; ++i) {
    ws.turn_sines[i] = 0;
    ws.turn_cosines[i] = 1;
  }
  plan.kernels->calc_angles(ws.turn_sines.data(), ws.turn_cosines.data(), count);
}

// Joints that are no edge of the tree.
void update_loose_joints(const Plan& plan, const State& state, BiasKind kind, Workspace& ws) {
  for (std::size_t i = 0; i < plan.loose_joints.size(); ++i) {
    const PlanLooseJoint& loose = plan.loose_joints[i];
    const PlanJoint& joint = plan.joints[at(loose.joint)];
    const BodyFrame base = get_body_frame(ws, joint.base), follower = get_body_frame(ws, joint.follower);
    JointFrame& f = ws.loose_frames[i];
    f.r_follower = follower.R * loose.point_follower;
    f.r_base = (follower.p - base.p) + f.r_follower;
    f.n = base.R * loose.axes;
    f.m = base.R * loose.rotation_axes;
    f.w_rel = follower.w - base.w;
    f.v_rel = (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base));
    f.displacement = transpose_times(f.n, f.r_base - base.R * loose.point_base);
    f.crossed = is_crossed(joint, get_active_rows(plan, state, loose.joint));
    if (f.crossed) f.m = universal_frame(f.m, follower.R * rotation_matrix(joint.rotation_follower));
  }
  for (const std::int32_t j : plan.loops)
    ws.loose_bias[at(plan.joints[at(j)].loose)] = calc_bias(plan, state, ws, j, kind);
}

}  // namespace

double calc_twist(const Mat3& base, const Mat3& follower, int k) noexcept {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  const Turn turn = calc_turn(column(base, i), column(base, j), column(follower, i), column(follower, j));
  return elementary::atan2(turn.sine, turn.cosine);
}

Quat calc_relative_attitude(const Plan& plan, const Workspace& ws, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  const auto get_attitude = [&](int body) { return read_quat(ws.lanes.data(), ws.slots[at(body)], kPose + 3); };
  const Quat base = j.base == kGround ? j.rotation_base : get_attitude(j.base) * j.rotation_base;
  return conjugate(base) * (get_attitude(j.follower) * j.rotation_follower);
}

BodyFrame get_body_frame(const Workspace& ws, int body) noexcept {
  if (body == kGround) return {kIdentity3, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const double* lanes = ws.lanes.data();
  const LaneSlot slot = ws.slots[at(body)];
  return {read_mat(lanes, slot, kRotation), read_vec(lanes, slot, kPose), read_vec(lanes, slot, kVelocity),
          read_vec(lanes, slot, kOmega)};
}

Mat3 calc_follower_axes(const Plan& plan, const Workspace& ws, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  return get_body_frame(ws, j.follower).R * rotation_matrix(j.rotation_follower);
}

JointFrame get_joint_frame(const Plan& plan, const State& state, const Workspace& ws, int joint) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  if (j.loose != kNone) return ws.loose_frames[at(j.loose)];
  const double* lanes = ws.lanes.data();
  const LaneSlot slot = ws.slots[at(j.child)];
  const Spatial slip = read_spatial(lanes, slot, kSlip);
  return {get_arm(plan, ws, joint, false),
          get_arm(plan, ws, joint, true),
          read_mat(lanes, slot, kAxes),
          read_mat(lanes, slot, j.rotation_row),
          is_crossed(j, get_active_rows(plan, state, joint)),
          read_vec(lanes, slot, kGap),
          slip.lin,
          slip.ang};
}

Vec3 get_axis(const Plan& plan, const Workspace& ws, int joint, int row) noexcept {
  return JointNumbers(plan, ws, joint).get_axis(row);
}

Vec3 get_arm(const Plan& plan, const Workspace& ws, int joint, bool of_follower) noexcept {
  const PlanJoint& j = plan.joints[at(joint)];
  if (j.loose != kNone) {
    const JointFrame& f = ws.loose_frames[at(j.loose)];
    return of_follower ? f.r_follower : f.r_base;
  }
  const bool of_child = j.child == (of_follower ? j.follower : j.base);
  const LaneSlot slot = ws.slots[at(j.child)];
  return of_child ? read_vec(ws.lanes.data(), slot, kArmChild) : read_vec(ws.lanes.data(), slot, kArmParent);
}

void update_kinematics(const Plan& plan, Workspace& ws) noexcept {
  update_markers(plan, ws);
  plan.kernels->update_kinematics(plan, ws);
  update_varying_kinematics(plan, ws);
  update_flexible_kinematics(plan, ws);
}

void update_rates(const Plan& plan, Workspace& ws) noexcept {
  update_markers(plan, ws);
  plan.kernels->update_rates(plan, ws);
}

void update_joints(const Plan& plan, const State& state, BiasKind kind, Workspace& ws) noexcept {
  plan.kernels->update_joints(plan, ws, kind);
  if (!plan.rigid) update_marker_biases(plan, kind, ws);
  if (!plan.loose_joints.empty()) update_loose_joints(plan, state, kind, ws);
}

void renew_joints(const Plan& plan, const State& state, Workspace& ws) noexcept {
  plan.kernels->renew_joints(plan, ws);
  if (!plan.rigid) update_marker_biases(plan, BiasKind::kAcceleration, ws);
  if (!plan.loose_joints.empty()) update_loose_joints(plan, state, BiasKind::kAcceleration, ws);
}

void update_coordinates(const Plan& plan, const State& state, bool all, Workspace& ws) noexcept {
  const std::span read = std::span(plan.coordinates).first(all ? plan.coordinates.size() : at(plan.driven_coordinates));
  std::size_t turns = 0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const PlanCoordinate& c = read[i];
    if (c.gap != kNone) {
      const double *axis = ws.lanes.data() + c.axis, *slip = ws.lanes.data() + c.slip;
      const std::int32_t y = c.stride, z = 2 * y;
      ws.speeds[i] = dot(Vec3{axis[0], axis[y], axis[z]}, Vec3{slip[0], slip[y], slip[z]});
      ws.coordinates[i] = ws.lanes[at(c.gap)];
      continue;
    }
    const JointNumbers numbers(plan, ws, c.joint);
    ws.speeds[i] = dot(numbers.get_axis(c.row), numbers.get_slip(c.row >= kRotX));
    if (c.row < kRotX) {
      const Vec3& d = ws.loose_frames[at(numbers.joint.loose)].displacement;
      ws.coordinates[i] = c.row == kX ? d.x : (c.row == kY ? d.y : d.z);
      continue;
    }
    const Turn turn = measure_turn(plan, state, ws, c, numbers);
    ws.turn_sines[turns] = turn.sine;
    ws.turn_cosines[turns++] = turn.cosine;
  }
  if (turns == 0) return;
  turn_into_angles(plan, turns, ws);
  turns = 0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const PlanCoordinate& c = read[i];
    if (c.row < kRotX) continue;
    const double previous = state.joints[at(c.joint)].angle[c.row - kRotX];
    ws.coordinates[i] = unwind(ws.turn_sines[turns++], previous);
  }
}

}  // namespace unlatch
