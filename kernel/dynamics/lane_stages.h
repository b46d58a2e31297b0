// What moves bodies, on octets of lanes: the stages of Runge–Kutta and of a step with implicit elements, and
// corrections. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/dynamics/lane_motion.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
UNLATCH_INLINE QuatT<T> normalized(const QuatT<T>& q) {
  const T s = T(1) / sqrt(norm_squared(q));
  return {q.w * s, q.x * s, q.y * s, q.z * s};
}

// --- Runge–Kutta ----------------------------------------------------------------------------------------------------

template <class T>
struct Rates {
  Vec3T<T> p;
  QuatT<T> q;
  Vec3T<T> v, w;
};

template <class V, class T = typename V::T>
UNLATCH_INLINE Rates<T> get_rates(const V& v) {
  return {v.get_vec(0), v.get_quat(3), v.get_vec(7), v.get_vec(10)};
}
template <class V, class T = typename V::T>
UNLATCH_INLINE void set_rates(const V& v, const Rates<T>& k) {
  v.set(0, k.p);
  v.set(3, k.q);
  v.set(7, k.v);
  v.set(10, k.w);
}
// a + s b
template <class T>
UNLATCH_INLINE Rates<T> add(const Rates<T>& a, const T& s, const Rates<T>& b) {
  return {a.p + s * b.p,
          {a.q.w + s * b.q.w, a.q.x + s * b.q.x, a.q.y + s * b.q.y, a.q.z + s * b.q.z},
          a.v + s * b.v,
          a.w + s * b.w};
}
template <class T>
UNLATCH_INLINE Rates<T> scale(const T& s, const Rates<T>& b) {
  return {s * b.p, {s * b.q.w, s * b.q.x, s * b.q.y, s * b.q.z}, s * b.v, s * b.w};
}

// Where a body is now, with its kinematics.
template <class V, class C, class T = typename V::T>
UNLATCH_INLINE void place(const V& v, const C& c, const Rates<T>& at) {
  set_rates(v.from(kPose), at);
  set_kinematics(v, c, at.q, at.w);
}

// Of the present pose and velocity.
template <class V, class T = typename V::T>
UNLATCH_INLINE Rates<T> calc_rates(const V& v) {
  return {v.get_vec(kVelocity), quaternion_rate(v.get_quat(kPose + 3), v.get_vec(kVelocity + 3)),
          v.get_vec(kAcceleration), transpose_times(v.get_mat(kRotation), v.get_vec(kAcceleration + 3))};
}

template <int kWidest>
void keep_start(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(plan, ws, []<class V>(const LaneOctet&, const V v, const auto&) {
    using T = typename V::T;
    set_rates(v.from(kStart), get_rates(v.from(kPose)));
    const Rates<T> k = calc_rates(v);
    v.set(kFirst, k.v);
    v.set(kFirst + 3, k.w);
  });
}

template <int kWidest>
void begin_stages(const Plan& plan, Workspace& ws, double weight, double h) {
  for_octets<kWidest>(plan, ws, [&]<class V>(const LaneOctet&, const V v, const auto c) {
    using T = typename V::T;
    const Rates<T> start = get_rates(v.from(kStart));
    const Rates<T> k{start.v, quaternion_rate(start.q, start.w), v.get_vec(kFirst), v.get_vec(kFirst + 3)};
    set_rates(v.from(kSum), scale(T(weight), k));
    place(v, c, add(start, T(h), k));
  });
}

template <int kWidest>
void advance_stage(const Plan& plan, Workspace& ws, double weight, double h) {
  for_octets<kWidest>(plan, ws, [&]<class V>(const LaneOctet&, const V v, const auto c) {
    using T = typename V::T;
    const Rates<T> k = calc_rates(v);
    set_rates(v.from(kSum), add(get_rates(v.from(kSum)), T(weight), k));
    place(v, c, add(get_rates(v.from(kStart)), T(h), k));
  });
}

template <int kWidest>
void finish_stages(const Plan& plan, Workspace& ws, double weight, double h) {
  for_octets<kWidest>(plan, ws, [&]<class V>(const LaneOctet&, const V v, const auto c) {
    using T = typename V::T;
    const Rates<T> sum = add(get_rates(v.from(kSum)), T(weight), calc_rates(v));
    Rates<T> end = add(get_rates(v.from(kStart)), T(h), sum);
    end.q = normalized(end.q);
    place(v, c, end);
  });
}

// The stages of a step with implicit elements, see compliance.h; `lead` is γ h.

// To the beginning.
template <int kWidest>
void restart(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(
      plan, ws, []<class V>(const LaneOctet&, const V v, const auto c) { place(v, c, get_rates(v.from(kStart))); });
}

// x' = v + lead a, v' = a
template <int kWidest>
void finish_first_stage(const Plan& plan, Workspace& ws, double h, double lead) {
  for_octets<kWidest>(plan, ws, [&]<class V>(const LaneOctet&, const V v, const auto c) {
    using T = typename V::T;
    const Rates<T> start = get_rates(v.from(kStart));
    Rates<T> k = calc_rates(v);
    k.p = start.v + T(lead) * k.v;
    k.q = quaternion_rate(start.q, start.w + T(lead) * k.w);
    set_rates(v.from(kSum), k);
    place(v, c, add(start, T(h), k));
  });
}

// x' = v + lead (a − 2 a1), v' = a; the quaternion's part of A stays that of the beginning. Then the mean of both
// stages.
template <int kWidest>
void finish_second_stage(const Plan& plan, Workspace& ws, double h, double lead) {
  for_octets<kWidest>(plan, ws, [&]<class V>(const LaneOctet&, const V v, const auto c) {
    using T = typename V::T;
    const Rates<T> start = get_rates(v.from(kStart)), first = get_rates(v.from(kSum));
    Rates<T> k = calc_rates(v);
    const QuatT<T> turn = quaternion_rate(start.q, T(lead) * (k.w - T(2) * first.w));
    k.p = k.p + T(lead) * (k.v - T(2) * first.v);
    k.q = {k.q.w + turn.w, k.q.x + turn.x, k.q.y + turn.y, k.q.z + turn.z};
    Rates<T> end = add(start, T(0.5 * h), add(first, T(1), k));
    end.q = normalized(end.q);
    place(v, c, end);
  });
}

// --- Corrections ----------------------------------------------------------------------------------------------------

template <int kWidest>
void add_displacements(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(plan, ws, []<class V>(const LaneOctet&, const V v, const auto c) {
    using T = typename V::T;
    const Vec3T<T> half = T(0.5) * v.get_vec(kAcceleration + 3);
    const QuatT<T> q = v.get_quat(kPose + 3);
    const QuatT<T> turn = QuatT<T>{T(0.0), half.x, half.y, half.z} * q;
    place(v, c,
          Rates<T>{v.get_vec(kPose) + v.get_vec(kAcceleration),
                   normalized(QuatT<T>{q.w + turn.w, q.x + turn.x, q.y + turn.y, q.z + turn.z}), v.get_vec(kVelocity),
                   v.get_vec(kVelocity + 3)});
  });
}

template <int kWidest>
void add_velocities(const Plan& plan, Workspace& ws) {
  for_octets<kWidest>(plan, ws, []<class V>(const LaneOctet&, const V v, const auto&) {
    using T = typename V::T;
    const Mat3T<T> R = v.get_mat(kRotation);
    const Vec3T<T> w = v.get_vec(kVelocity + 3) + transpose_times(R, v.get_vec(kAcceleration + 3));
    v.set(kVelocity, v.get_vec(kVelocity) + v.get_vec(kAcceleration));
    v.set(kVelocity + 3, w);
    v.set(kOmega, R * w);
  });
}

}  // namespace unlatch::UNLATCH_ISA
