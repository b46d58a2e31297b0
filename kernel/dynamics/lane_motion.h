// What follows from poses and velocities, on lanes: kinematics, forces that the bodies sum by themselves, joint frames
// and their biases. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/dispatch/lane_kernels.h"
#include "kernel/simd/lane_view.h"

namespace unlatch::UNLATCH_ISA {

// Calls run(pack, width): the widest pack that this build has for a group, and the group's width, both to the compiler.
template <int kWidest, class Run>
UNLATCH_INLINE void for_width(const LaneGroup& group, const Run& run) {
  // NOLINTNEXTLINE(bugprone-branch-clone): alike for the width at hand only
  constexpr int kFour = kWidest < 4 ? kWidest : 4, kTwo = kWidest < 2 ? kWidest : 2;
  switch (group.width) {
    case 8:
      return run.template operator()<Pack<kWidest>, 8>();
    case 4:
      return run.template operator()<Pack<kFour>, 4>();
    case 2:
      return run.template operator()<Pack<kTwo>, 2>();
    default:
      return run.template operator()<Pack<1>, 1>();
  }
}

// The same for an octet, as wide as its lanes are in use.
template <int kWidest, class Run>
UNLATCH_INLINE void for_octet_width(const LaneOctet& octet, const Run& run) {
  // NOLINTNEXTLINE(bugprone-branch-clone)
  constexpr int kFour = kWidest < 4 ? kWidest : 4, kTwo = kWidest < 2 ? kWidest : 2;
  if (octet.lanes > 0xf) return run.template operator()<Pack<kWidest>>();
  if (octet.lanes > 3) return run.template operator()<Pack<kFour>>();
  if (octet.lanes > 1) return run.template operator()<Pack<kTwo>>();
  return run.template operator()<Pack<1>>();
}

// Calls stage(octet, view of its blocks, view of its constants) for every octet, part by part.
template <int kWidest, class Stage>
UNLATCH_INLINE void for_octets(const Plan& plan, Workspace& ws, const Stage& stage) {
  double* lanes = ws.lanes.data();
  const double* constants = plan.body_constants.data();
  const LaneOctet* end = plan.octets.data() + plan.octets.size();
  for (const LaneOctet* octet = plan.octets.data(); octet != end; ++octet)
    for_octet_width<kWidest>(*octet, [&]<class T>() {
      for (int lane = 0; octet->lanes >> lane != 0; lane += T::kWidth)
        stage(*octet, View<T, kOctet>{nullptr, nullptr, lanes + octet->body + lane, lanes + octet->shared + lane},
              View<T, kOctet, const double>{nullptr, nullptr, constants + octet->constants + lane});
    });
}

// --- Kinematics and forces ------------------------------------------------------------------------------------------

template <class V, class C, class T = typename V::T>
UNLATCH_INLINE void set_kinematics(const V& v, const C& c, const QuatT<T>& q, const Vec3T<T>& w) {
  const Mat3T<T> R = rotation_matrix(q);
  v.set(kRotation, R);
  v.set(kOmega, R * w);
  v.set(kInertia, rotate(R, c.get_sym(kBodyInertia)));
}

template <int kWidest>
void update_kinematics(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(plan, ws, [](const LaneOctet&, const auto v, const auto c) {
    set_kinematics(v, c, v.get_quat(kPose + 3), v.get_vec(kVelocity + 3));
  });
}

template <int kWidest>
void update_rates(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(plan, ws, [](const LaneOctet&, const auto v, const auto&) {
    v.set(kOmega, v.get_mat(kRotation) * v.get_vec(kVelocity + 3));
  });
}

template <class T>
struct Frame {
  Mat3T<T> R;
  Vec3T<T> p, v, w;
};

template <class T, class Source>
UNLATCH_INLINE Frame<T> get_frame(const Source& from) {
  return {get_mat(from, kRotation), get_vec(from, kPose), get_vec(from, kVelocity), get_vec(from, kOmega)};
}

// Weight, gyroscopic torque, and loads that are fixed in the body. Empty lanes have no mass and are away from the
// centre of gravity, see lane_state.cc.
template <int kWidest>
void init_forces(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(plan, ws, [&]<class V>(const LaneOctet& octet, const V v, const auto c) {
    using T = typename V::T;
    Vec3T<T> g{T(plan.gravity.x), T(plan.gravity.y), T(plan.gravity.z)};
    if (plan.mu != 0) {
      const Vec3T<T> r = v.get_vec(kPose) - Vec3T<T>{T(plan.mu_centre.x), T(plan.mu_centre.y), T(plan.mu_centre.z)};
      const T r2 = dot(r, r);
      g = g - (T(plan.mu) / (r2 * sqrt(r2))) * r;
    }
    const Vec3T<T> w = v.get_vec(kOmega);
    SpatialT<T> force{c.get(kBodyMass) * g, -cross(w, v.get_sym(kInertia) * w)};
    if (octet.loaded) {
      const Mat3T<T> R = v.get_mat(kRotation);
      force = force + SpatialT<T>{R * v.get_vec(kApplied), R * v.get_vec(kApplied + 3)};
    }
    v.set(kForce, force);
  });
}

// --- Joints ---------------------------------------------------------------------------------------------------------

template <class T>
UNLATCH_INLINE Frame<T> get_ground() {
  const T o(0.0), i(1.0);
  const Vec3T<T> zero{o, o, o};
  return {{{i, o, o}, {o, i, o}, {o, o, i}}, zero, zero, zero};
}

template <class T>
struct JointMotion {
  const Frame<T>&base, &follower;
  Vec3T<T> r_base, r_follower, arm_child, gap, v_rel, w_rel;
  Mat3T<T> n, m;

  UNLATCH_INLINE void update_slip() {
    v_rel = (follower.v + cross(follower.w, r_follower)) - (base.v + cross(base.w, r_base));
    w_rel = follower.w - base.w;
  }
};

// In its modes with rot_z as the only rotation row a universal joint's rotation frame follows the cross: x of the base,
// y of the follower, and their common normal, which the row is about.
template <class V, class C, class T>
UNLATCH_INLINE void cross_axes(const V& v, const C& c, const LaneGroup& group, JointMotion<T>& j) {
  const T crossed = v.get(group.crossed);
  const Vec3T<T> normal = cross(j.m.x, j.follower.R * c.get_vec(kFollowerY));
  const Vec3T<T> z = (T(1) / sqrt(dot(normal, normal))) * normal;
  j.m.y = select(crossed, cross(z, j.m.x), j.m.y);
  j.m.z = select(crossed, z, j.m.z);
}

// The mask of no lane at all, known to the compiler.
struct Nowhere {};
template <class A>
UNLATCH_INLINE const A& select(Nowhere, const A&, const A& otherwise) {
  return otherwise;
}

template <class T>
UNLATCH_INLINE Frame<T> select(const T& mask, const Frame<T>& a, const Frame<T>& b) {
  return {{select(mask, a.R.x, b.R.x), select(mask, a.R.y, b.R.y), select(mask, a.R.z, b.R.z)},
          select(mask, a.p, b.p),
          select(mask, a.v, b.v),
          select(mask, a.w, b.w)};
}

template <class V, class C, class Side, class T = typename V::T>
UNLATCH_INLINE JointMotion<T> calc_joint(const LaneGroup& group, const V& v, const C& c, const Frame<T>& base,
                                         const Frame<T>& follower, const Side& child_is_base) {
  const Vec3T<T> r_follower = follower.R * c.get_vec(kPointFollower);
  const Vec3T<T> r_base = (follower.p - base.p) + r_follower;
  const Mat3T<T> n = base.R * c.get_mat(kBaseAxes);
  JointMotion<T> j{base,
                   follower,
                   r_base,
                   r_follower,
                   select(child_is_base, r_base, r_follower),
                   transpose_times(n, r_base - base.R * c.get_vec(kPointBase)),
                   {},
                   {},
                   n,
                   group.shared_axes ? n : base.R * c.get_mat(kRotationAxes)};
  j.update_slip();
  if (group.universal) cross_axes(v, c, group, j);
  v.set(kArmChild, j.arm_child);
  v.set(kArmParent, select(child_is_base, r_follower, r_base));
  v.set(kAxes, n);
  if (!group.shared_axes) v.set(group.rotation_axes, j.m);
  v.set(kGap, j.gap);
  return j;
}

// The same where neither poses nor modes have changed since: without the gap, and axes only where a cross has turned
// them.
template <class V, class Side, class T = typename V::T>
UNLATCH_INLINE JointMotion<T> read_joint(const LaneGroup& group, const V& v, const Frame<T>& base,
                                         const Frame<T>& follower, const Side& child_is_base) {
  const Vec3T<T> arm_child = v.get_vec(kArmChild), arm_parent = v.get_vec(kArmParent);
  JointMotion<T> j{base,
                   follower,
                   select(child_is_base, arm_child, arm_parent),
                   select(child_is_base, arm_parent, arm_child),
                   arm_child,
                   {},
                   {},
                   {},
                   {},
                   {}};
  if (group.universal) j.m = v.get_mat(group.rotation_axes);
  j.update_slip();
  return j;
}

// The right-hand sides of the rows, (4.11) and (4.12):
//   point–plane: w_b × (w_b × r_b) + 2 w_b × v_rel − w_f × (w_f × r_f)
//   n fixed in the base:   d/dt n·(w_f − w_b) = n·(α_f − α_b + w_f × w_b) = 0, so α_f − α_b = w_b × w_f along n;
//   n = N/|N|, N = x_b × y_f: g = x_b·y_f, dg/dt = −N·w_rel, so N·α_rel = −(dN/dt)·w_rel.
template <class V, class C, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> calc_acceleration_bias(const LaneGroup& group, const V& v, const C& c,
                                                  const JointMotion<T>& j) {
  const Vec3T<T>&wb = j.base.w, &wf = j.follower.w;
  SpatialT<T> bias{(cross(wb, cross(wb, j.r_base)) + T(2) * cross(wb, j.v_rel)) - cross(wf, cross(wf, j.r_follower)),
                   cross(wb, wf)};
  if (group.universal) {
    const Vec3T<T> y = j.follower.R * c.get_vec(kFollowerY);
    const Vec3T<T> normal = cross(j.m.x, y);
    const Vec3T<T> rate = cross(cross(wb, j.m.x), y) + cross(j.m.x, cross(wf, y));
    const T size = -dot(rate, j.w_rel) / sqrt(dot(normal, normal));
    bias.ang = select(v.get(group.crossed), size * j.m.z, bias.ang);
  }
  return bias;
}

// The gaps, reversed. Orientation: for every axis a whose place in the follower is kept, a × (where it has gone); a
// universal joint's row: −x_b·y_f / |x_b × y_f|.
template <class V, class C, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> calc_position_bias(const LaneGroup& group, const V& v, const C& c, const JointMotion<T>& j) {
  const T o(0.0);
  SpatialT<T> bias{-(j.n * (j.gap - v.get_vec(group.carried_axes))), {o, o, o}};
  JointField part = group.carried_axes + kOffsetFields;
  for (int a = 0; a < 3; ++a) {
    if ((group.carried >> a & 1) == 0) continue;
    const Vec3T<T>& axis = a == 0 ? j.m.x : (a == 1 ? j.m.y : j.m.z);
    bias.ang -= cross(axis, j.follower.R * v.get_vec(part));
    part = part + 3;
  }
  if (group.universal) {
    const Vec3T<T> y = j.follower.R * c.get_vec(kFollowerY);
    const Vec3T<T> normal = cross(j.m.x, y);
    const T size = dot(j.m.x, y) / sqrt(dot(normal, normal));
    bias.ang = select(v.get(group.crossed), size * j.m.z, bias.ang);
  }
  return bias;
}

// A correction must not ask for anything along the freedoms: what it would ask is large beside the gaps.
template <class V, class T = typename V::T>
UNLATCH_INLINE void remove_freedoms(const LaneGroup& group, const V& v, const JointMotion<T>& j, SpatialT<T>& bias) {
  for (int r = 0; r < kRows; ++r) {
    if (!has_row(group.freedoms, r)) continue;
    const Mat3T<T>& axes = r < kRotX ? j.n : j.m;
    const Vec3T<T>& axis = r % 3 == 0 ? axes.x : (r % 3 == 1 ? axes.y : axes.z);
    Vec3T<T>& along = r < kRotX ? bias.lin : bias.ang;
    along -= (v.get(group.freedom_parts[r] + kMask) & dot(axis, along)) * axis;
  }
}

// From the joint's point to the child's origin, with the child's sign.
template <class V, class C, class T = typename V::T>
UNLATCH_INLINE void set_bias(const V& v, const C& c, const JointMotion<T>& j, SpatialT<T> bias) {
  v.set(kSlip, j.v_rel);
  v.set(kSlip + 3, j.w_rel);
  bias = c.get(kSide) * bias;
  bias.lin -= cross(bias.ang, j.arm_child);
  v.set(kBias, bias);
}

template <class V, class C, class Side, class T = typename V::T>
UNLATCH_INLINE void update_joint(const LaneGroup& group, const V& v, const C& c, const Frame<T>& base,
                                 const Frame<T>& follower, const Side& child_is_base, BiasKind kind) {
  const JointMotion<T> j = calc_joint(group, v, c, base, follower, child_is_base);
  SpatialT<T> bias;
  if (kind == BiasKind::kAcceleration) {
    bias = calc_acceleration_bias(group, v, c, j);
  } else {
    bias = kind == BiasKind::kVelocity ? SpatialT<T>{-j.v_rel, -j.w_rel} : calc_position_bias(group, v, c, j);
    remove_freedoms(group, v, j, bias);
  }
  v.set(kOffset, select(child_is_base, base.p - follower.p, follower.p - base.p));
  set_bias(v, c, j, bias);
}

// Calls update(group, block, constants, base, follower, where the child is the base) for every group of joints, part by
// part.
template <int kWidest, class Update>
UNLATCH_INLINE void for_joints(const Plan& plan, Workspace& ws, const Update& update) {
  double* lanes = ws.lanes.data();
  const LaneGroup* end = plan.groups.data() + plan.groups.size();
  for (const LaneGroup* group = plan.groups.data(); group != end; ++group) {
    if (!group->has_joint) continue;
    for_width<kWidest>(*group, [&]<class T, int kWidth>() {
      for (int lane = 0; lane < kWidth; lane += T::kWidth) {
        const auto v = get_view<T, kWidth>(*group, lanes, lane);
        const auto c = get_constants<T, kWidth>(plan, *group, lane);
        const Parents<T> parents{group->link, lanes, plan.lane_parents.data() + group->first + lane};
        const Frame<T> child = get_frame<T>(v);
        const Frame<T> parent = group->link == LaneLink::kRoot
                                    ? get_ground<T>()
                                    : parents.visit([](const auto& from) { return get_frame<T>(from); });
        if (group->sides == LaneSides::kFollowers) {
          update(*group, v, c, parent, child, Nowhere{});
          continue;
        }
        const T child_is_base = T(0.0) > c.get(kSide);
        update(*group, v, c, select(child_is_base, child, parent), select(child_is_base, parent, child), child_is_base);
      }
    });
  }
}

template <int kWidest>
void update_joints(const Plan& plan, Workspace& ws, BiasKind kind) {
  if (kind == BiasKind::kAcceleration) init_forces<kWidest>(plan, ws);
  for_joints<kWidest>(plan, ws, [&](const LaneGroup& group, const auto&... joint) UNLATCH_INLINE_LAMBDA {
    update_joint(group, joint..., kind);
  });
}

template <int kWidest>
void renew_joints(const Plan& plan, Workspace& ws) {
  init_forces<kWidest>(plan, ws);
  for_joints<kWidest>(
      plan, ws, [](const LaneGroup& group, const auto& v, const auto& c, const auto&... joint) UNLATCH_INLINE_LAMBDA {
        const auto j = read_joint(group, v, joint...);
        set_bias(v, c, j, calc_acceleration_bias(group, v, c, j));
      });
}

}  // namespace unlatch::UNLATCH_ISA
