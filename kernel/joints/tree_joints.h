// Frames of the tree's joints and the right-hand sides of their rows, in groups. Compiled once per instruction set, see
// kernel/simd/pack.h.
#pragma once

#include "kernel/joints/joint_motion.h"
#include "kernel/plan/group_view.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
UNLATCH_INLINE BodyFrameT<T> load_frame(const BodyBlock<Wide<kEight>>& body) {
  return {load<T>(body.R), load<T>(body.motion.p), load<T>(body.motion.v), load<T>(body.w_W)};
}
template <class T, class Parents>
UNLATCH_INLINE BodyFrameT<T> load_parent_frame(const Parents& parents) {
  using Body = BodyBlock<double>;
  using Motion = MotionT<double>;
  return {load(parents, &Body::R), load(parents, &Body::motion, &Motion::p), load(parents, &Body::motion, &Motion::v),
          load(parents, &Body::w_W)};
}

// The mask of no lane at all, known to the compiler.
struct Nowhere {};
template <class A>
UNLATCH_INLINE const A& select(Nowhere, const A&, const A& otherwise) {
  return otherwise;
}

template <class T>
UNLATCH_INLINE BodyFrameT<T> select(const T& mask, const BodyFrameT<T>& a, const BodyFrameT<T>& b) {
  return {{select(mask, a.R.x, b.R.x), select(mask, a.R.y, b.R.y), select(mask, a.R.z, b.R.z)},
          select(mask, a.p, b.p),
          select(mask, a.v, b.v),
          select(mask, a.w, b.w)};
}

// The two bodies of each joint, and the lanes in which the child is the base.
template <class T, class Side>
struct JointEnds {
  const BodyFrameT<T>&base, &follower;
  const Side& child_is_base;
};

template <class V, class E, class T = typename V::T>
UNLATCH_INLINE Vec3T<T> calc_follower_y(const V& v, const E& ends) {
  return ends.follower.R * load<T>(v.constants.rotation().follower_y);
}

// From poses, and stored with them.
template <class V, class E, class T = typename V::T>
UNLATCH_INLINE JointFrameT<T> calc_frame(const V& v, const E& ends) {
  const auto& c = v.constants.joint();
  JointFrameT<T> f =
      calc_joint_frame(ends.base, ends.follower, load<T>(c.point_base), load<T>(c.point_follower), load<T>(c.axes));
  if (!v.group.shared_axes) f.m = ends.base.R * load<T>(v.constants.rotation().axes);
  if (v.group.universal) {
    f.crossed = load<T>(v.blocks.crossed());
    cross_axes(calc_follower_y(v, ends), f);
  }
  store(v.blocks.solver().arm_child, select(ends.child_is_base, f.r_base, f.r_follower));
  store(v.blocks.joint().arm_parent, select(ends.child_is_base, f.r_follower, f.r_base));
  store(v.blocks.solver().axes, f.n);
  if (!v.group.shared_axes) store(v.blocks.rotation_axes(), f.m);
  store(v.blocks.joint().displacement, f.displacement);
  store(v.blocks.solver().offset,
        select(ends.child_is_base, ends.base.p - ends.follower.p, ends.follower.p - ends.base.p));
  return f;
}

// The stored frame with the present slip, for accelerations: `displacement` and `n` are unset, and without a cross also
// `m` and `crossed`.
template <class V, class E, class T = typename V::T>
UNLATCH_INLINE JointFrameT<T> load_frame_with_slip(const V& v, const E& ends) {
  const Vec3T<T> arm_child = load<T>(v.blocks.solver().arm_child), arm_parent = load<T>(v.blocks.joint().arm_parent);
  JointFrameT<T> f;
  f.r_base = select(ends.child_is_base, arm_child, arm_parent);
  f.r_follower = select(ends.child_is_base, arm_parent, arm_child);
  if (v.group.universal) {
    f.m = load<T>(v.blocks.rotation_axes());
    f.crossed = load<T>(v.blocks.crossed());
  }
  update_slip(ends.base, ends.follower, f);
  return f;
}

template <class V, class E, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> calc_acceleration_bias(const V& v, const E& ends, const JointFrameT<T>& f) {
  SpatialT<T> bias = calc_acceleration_target(ends.base, ends.follower, f);
  if (v.group.universal)
    bias.ang =
        select(f.crossed, calc_cross_acceleration(ends.base.w, ends.follower.w, calc_follower_y(v, ends), f), bias.ang);
  return bias;
}

// Orientation: for every axis a whose place in the follower is kept, a × (where it is now).
template <class V, class E, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> calc_position_bias(const V& v, const E& ends, const JointFrameT<T>& f) {
  const T o(0.0);
  SpatialT<T> bias{calc_position_target(f, load<T>(v.blocks.carried().offset)), {o, o, o}};
  int kept = 0;
  for (int a = 0; a < 3; ++a) {
    if ((v.group.carried >> a & 1) == 0) continue;
    bias.ang -= cross(column(f.m, a), ends.follower.R * load<T>(v.blocks.carried_axis(kept++)));
  }
  if (v.group.universal) bias.ang = select(f.crossed, calc_cross_target(calc_follower_y(v, ends), f) * f.m.z, bias.ang);
  return bias;
}

// Takes the part along the freedoms out of a correction: it would be large beside the residuals.
template <class V, class T = typename V::T>
UNLATCH_INLINE void remove_freedoms(const V& v, const JointFrameT<T>& f, SpatialT<T>& bias) {
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(v.group.freedoms, r)) continue;
    const Vec3T<T>& axis = column(r < kRotX ? f.n : f.m, r % 3);
    Vec3T<T>& along = r < kRotX ? bias.lin : bias.ang;
    along -= (load<T>(v.blocks.freedom(r).mask) & dot(axis, along)) * axis;
  }
}

// From the joint's point to the child's origin, with the child's sign.
template <class V, class T = typename V::T>
UNLATCH_INLINE void store_bias(const V& v, const Vec3T<T>& arm_child, const JointFrameT<T>& f, SpatialT<T> bias) {
  store(v.blocks.joint().slip, SpatialT<T>{f.v_rel, f.w_rel});
  bias = load<T>(v.constants.solver().side) * bias;
  bias.lin -= cross(bias.ang, arm_child);
  store(v.blocks.solver().bias, bias);
}

template <class V, class E, class T = typename V::T>
UNLATCH_INLINE void update_joint(const V& v, const E& ends, RowTarget target) {
  const JointFrameT<T> f = calc_frame(v, ends);
  SpatialT<T> bias;
  if (target == RowTarget::kAcceleration) {
    bias = calc_acceleration_bias(v, ends, f);
  } else {
    bias = target == RowTarget::kVelocity ? calc_velocity_target(f) : calc_position_bias(v, ends, f);
    remove_freedoms(v, f, bias);
  }
  store_bias(v, select(ends.child_is_base, f.r_base, f.r_follower), f, bias);
}

// Calls update(view, ends) for every group of joints, part by part.
template <int kWidest, class Update>
UNLATCH_INLINE void for_joints(const PlanData& plan, Evaluation& ev, const Update& update) {
  const std::span<const Group> groups = plan.groups;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const Group& group = groups[g];
    if (!group.has_joint) continue;
    for_width<kWidest>(group, [&]<class T, int kWidth>() {
      for (int lane = 0; lane < kWidth; lane += T::kWidth) {
        const GroupView<T, kWidth> v(plan, ev, g, lane);
        const BodyFrameT<T> child = load_frame<T>(v.blocks.body());
        const BodyFrameT<T> parent =
            group.link == ParentLink::kRoot
                ? get_ground<T>()
                : visit_parents(v, [](const auto& parents) { return load_parent_frame<T>(parents); });
        if (group.side == ChildSide::kFollower) {
          update(v, JointEnds<T, Nowhere>{parent, child, Nowhere{}});
          continue;
        }
        const T child_is_base = T(0.0) > load<T>(v.constants.solver().side);
        update(v, JointEnds<T, T>{select(child_is_base, child, parent), select(child_is_base, parent, child),
                                  child_is_base});
      }
    });
  }
}

// Frames of the tree's joints, and the relative motion that their rows prescribe, from the bodies' kinematics.
template <int kWidest>
void update_joints(const PlanData& plan, Evaluation& ev, RowTarget target) {
  for_joints<kWidest>(plan, ev,
                      [&](const auto& v, const auto& ends) UNLATCH_INLINE_LAMBDA { update_joint(v, ends, target); });
}

// The same for accelerations alone, with the frames that are stored: those of the present poses and modes.
template <int kWidest>
void update_joint_velocities(const PlanData& plan, Evaluation& ev) {
  for_joints<kWidest>(plan, ev, [](const auto& v, const auto& ends) UNLATCH_INLINE_LAMBDA {
    using T = typename std::remove_cvref_t<decltype(v)>::T;
    const auto f = load_frame_with_slip(v, ends);
    store_bias(v, load<T>(v.blocks.solver().arm_child), f, calc_acceleration_bias(v, ends, f));
  });
}

}  // namespace unlatch::UNLATCH_ISA
