// Kinematics of bodies and the forces that each body sums by itself, in blocks of eight. Compiled once per instruction
// set, see kernel/simd/pack.h.
#pragma once

#include "kernel/elements/gravity.h"
#include "kernel/plan/group_view.h"

namespace unlatch::UNLATCH_ISA {

template <class V, class T = typename V::T>
UNLATCH_INLINE void store_kinematics(const V& v, const QuatT<T>& q, const Vec3T<T>& w) {
  const Mat3T<T> R = rotation_matrix(q);
  store(v.body.R, R);
  store(v.body.w_W, R * w);
  store(v.shared.inertia, rotate(R, load<T>(v.constants.inertia)));
}

// Rotation, angular velocity and inertia in world axes, from pose and velocity.
template <int kWidest>
void update_kinematics(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, []<class V>(const V v) {
    using T = typename V::T;
    store_kinematics(v, load<T>(v.body.motion.q), load<T>(v.body.motion.w));
  });
}

// The angular velocity alone; rotations are those of the present poses.
template <int kWidest>
void update_angular_velocities(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, []<class V>(const V v) {
    using T = typename V::T;
    store(v.body.w_W, load<T>(v.body.R) * load<T>(v.body.motion.w));
  });
}

// Forces begin with weight, gyroscopic torque and the loads that are fixed in the body. Empty lanes have no mass and
// are away from the centre of gravity, see kernel/integration/load_state.cc.
template <int kWidest>
void init_forces(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, [&]<class V>(const V v) {
    using T = typename V::T;
    const Vec3T<T> g = calc_gravity<T>(plan.gravity, [&] { return load<T>(v.body.motion.p); });
    const Vec3T<T> w = load<T>(v.body.w_W);
    SpatialT<T> force{load<T>(v.constants.mass) * g, -cross(w, load<T>(v.shared.inertia) * w)};
    if (v.eight.loaded) {
      const Mat3T<T> R = load<T>(v.body.R);
      const SpatialT<T> applied = load<T>(v.applied.wrench);
      force = force + SpatialT<T>{R * applied.lin, R * applied.ang};
    }
    store(v.shared.force, force);
  });
}

}  // namespace unlatch::UNLATCH_ISA
