// A joint's frame and the right-hand sides of its rows, from the frames of its two bodies: one body at a time (T =
// double) or several (T a pack). Trees and loops share it.
//
// Symbols, world axes: b the base, f the follower; r_b, r_f from each body's origin to the follower's point; n the axes
// of the point–plane rows (4.11), m those of the rotation rows (4.12), both carried by the base.
#pragma once

#include "kernel/plan/evaluation.h"

namespace unlatch {

// The right-hand side of the rows.
enum class RowTarget : std::int32_t {
  kAcceleration,  // for accelerations
  kVelocity,      // for a velocity correction: the velocity residual, reversed
  kPosition,      // for a displacement: the position residual, reversed
};

// A body, or the ground.
template <class T>
struct BodyFrameT {
  Mat3T<T> R;        // R_WB
  Vec3T<T> p, v, w;  // world axes
};
using BodyFrame = BodyFrameT<double>;

template <class T>
UNLATCH_INLINE BodyFrameT<T> get_ground() {
  const T o(0.0), i(1.0);
  const Vec3T<T> zero{o, o, o};
  return {{{i, o, o}, {o, i, o}, {o, o, i}}, zero, zero, zero};
}

UNLATCH_INLINE Vec3 select(bool mask, const Vec3& a, const Vec3& b) { return mask ? a : b; }

// The velocity of the follower's point seen from the base, and the relative angular velocity.
template <class T>
UNLATCH_INLINE void update_slip(const BodyFrameT<T>& base, const BodyFrameT<T>& follower, JointFrameT<T>& f) {
  f.v_rel = (follower.v + cross(follower.w, f.r_follower)) - (base.v + cross(base.w, f.r_base));
  f.w_rel = follower.w - base.w;
}

// Arms, axes and displacement, and the slip. `axes`: of the point–plane rows, base axes. m is n: the caller replaces it
// where rotation rows have other axes. `crossed` is unset.
template <class T>
UNLATCH_INLINE JointFrameT<T> calc_joint_frame(const BodyFrameT<T>& base, const BodyFrameT<T>& follower,
                                               const Vec3T<T>& point_base, const Vec3T<T>& point_follower,
                                               const Mat3T<T>& axes) {
  JointFrameT<T> f;
  f.r_follower = follower.R * point_follower;
  f.r_base = (follower.p - base.p) + f.r_follower;
  f.n = f.m = base.R * axes;
  f.displacement = transpose_times(f.n, f.r_base - base.R * point_base);
  update_slip(base, follower, f);
  return f;
}

// The rotation frame of a universal joint follows its cross in the modes with rot_z as the only rotation row: x of the
// base, y of the follower, and their common normal, which the row is about. `y`: y of the rotation frame as the
// follower carries it, world axes.
template <class T>
UNLATCH_INLINE void cross_axes(const Vec3T<T>& y, JointFrameT<T>& f) {
  using std::sqrt;
  const Vec3T<T> normal = cross(f.m.x, y);
  const Vec3T<T> z = (T(1) / sqrt(dot(normal, normal))) * normal;
  f.m.y = select(f.crossed, cross(z, f.m.x), f.m.y);
  f.m.z = select(f.crossed, z, f.m.z);
}

// Relative acceleration that the rows prescribe, at the follower's point and about it:
//   point–plane:            w_b × (w_b × r_b) + 2 w_b × v_rel − w_f × (w_f × r_f)
//   n fixed in the base:    d/dt n·(w_f − w_b) = n·(α_f − α_b + w_f × w_b) = 0, so α_f − α_b = w_b × w_f along n
template <class T>
UNLATCH_INLINE SpatialT<T> calc_acceleration_target(const BodyFrameT<T>& base, const BodyFrameT<T>& follower,
                                                    const JointFrameT<T>& f) {
  const Vec3T<T>&wb = base.w, &wf = follower.w;
  return {(cross(wb, cross(wb, f.r_base)) + T(2) * cross(wb, f.v_rel)) - cross(wf, cross(wf, f.r_follower)),
          cross(wb, wf)};
}
//   the cross, N = x_b × y_f:  g = x_b·y_f, dg/dt = −N·w_rel, so N·α_rel = −(dN/dt)·w_rel
template <class T>
UNLATCH_INLINE Vec3T<T> calc_cross_acceleration(const Vec3T<T>& wb, const Vec3T<T>& wf, const Vec3T<T>& y,
                                                const JointFrameT<T>& f) {
  using std::sqrt;
  const Vec3T<T> normal = cross(f.m.x, y);
  const Vec3T<T> rate = cross(cross(wb, f.m.x), y) + cross(f.m.x, cross(wf, y));
  return (-dot(rate, f.w_rel) / sqrt(dot(normal, normal))) * f.m.z;
}

template <class T>
UNLATCH_INLINE SpatialT<T> calc_velocity_target(const JointFrameT<T>& f) {
  return {-f.v_rel, -f.w_rel};
}

// Displacement of the follower that closes the point–plane rows, world axes, m; `offset`: the displacements along the
// rows' axes at which they hold.
template <class T>
UNLATCH_INLINE Vec3T<T> calc_position_target(const JointFrameT<T>& f, const Vec3T<T>& offset) {
  return -(f.n * (f.displacement - offset));
}
// x_b·y_f / |x_b × y_f| of the cross: its position residual, reversed, about m.z.
template <class T>
UNLATCH_INLINE T calc_cross_target(const Vec3T<T>& y, const JointFrameT<T>& f) {
  using std::sqrt;
  const Vec3T<T> normal = cross(f.m.x, y);
  return dot(f.m.x, y) / sqrt(dot(normal, normal));
}

}  // namespace unlatch
