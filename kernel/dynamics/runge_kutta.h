// The stages of a sub-step, and corrections: bodies in blocks of eight, and auxiliary states, which are first-order
// scalars, by the same formulas. Functions that move bodies update their kinematics. Compiled once per instruction
// set, see kernel/simd/pack.h.
//
//   RK4    k1 … k4 with the weights 1/6, 1/3, 1/3, 1/6: begin_stages, advance_stage twice, finish_stages
//   ROS2   kernel/elements/compliance.h: restart, finish_first_stage, finish_second_stage; `gamma_h` is γ h. Both rates
//          have the weight 1, and the motion goes h/2 along their sum, so that in between the sum is the first rate.
#pragma once

#include "kernel/dynamics/body_motion.h"

namespace unlatch::UNLATCH_ISA {

template <class T, int W>
UNLATCH_INLINE MotionT<T> load(const MotionT<Wide<W>>& a) {
  return {load<T>(a.p), load<T>(a.q), load<T>(a.v), load<T>(a.w)};
}
template <class T, int W>
UNLATCH_INLINE void store(MotionT<Wide<W>>& to, const MotionT<T>& a) {
  store(to.p, a.p);
  store(to.q, a.q);
  store(to.v, a.v);
  store(to.w, a.w);
}

// a + s b
template <class T>
UNLATCH_INLINE MotionT<T> add(const MotionT<T>& a, const T& s, const MotionT<T>& b) {
  return {a.p + s * b.p,
          {a.q.w + s * b.q.w, a.q.x + s * b.q.x, a.q.y + s * b.q.y, a.q.z + s * b.q.z},
          a.v + s * b.v,
          a.w + s * b.w};
}
template <class T>
UNLATCH_INLINE MotionT<T> scale(const T& s, const MotionT<T>& b) {
  return {s * b.p, {s * b.q.w, s * b.q.x, s * b.q.y, s * b.q.z}, s * b.v, s * b.w};
}

// Moves a body, and updates its kinematics.
template <class V, class T = typename V::T>
UNLATCH_INLINE void place(const V& v, const MotionT<T>& motion) {
  store(v.body.motion, motion);
  store_kinematics(v, motion.q, motion.w);
}

// Rates of the present motion.
template <class V, class T = typename V::T>
UNLATCH_INLINE MotionT<T> calc_rates(const V& v) {
  const SpatialT<T> a = load<T>(v.shared.acceleration);
  const MotionT<T> now = load<T>(v.body.motion);
  return {now.v, quaternion_rate(now.q, now.w), a.lin, transpose_times(load<T>(v.body.R), a.ang)};
}

// --- Beginning -------------------------------------------------------------------------------------------------------

// The present motion and its rates become the beginning of a sub-step.
template <int kWidest>
void begin_substep(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, []<class V>(const V v) {
    using T = typename V::T;
    store(v.body.start, load<T>(v.body.motion));
    const MotionT<T> rates = calc_rates(v);
    store(v.body.start_v_rate, rates.v);
    store(v.body.start_w_rate, rates.w);
  });
  const Auxiliary& x = ev.auxiliary;
  for (std::size_t i = 0; i < x.now.size(); ++i) {
    x.start[i] = x.now[i];
    x.first[i] = x.rate[i];
  }
}

// --- RK4 -------------------------------------------------------------------------------------------------------------

// The sum begins with `weight` of the rates at the beginning; the motion goes `h` seconds along them.
template <int kWidest>
void begin_stages(const PlanData& plan, Evaluation& ev, double weight, double h) {
  for_bodies<kWidest>(plan, ev, [&]<class V>(const V v) {
    using T = typename V::T;
    const MotionT<T> start = load<T>(v.body.start);
    const MotionT<T> rates{start.v, quaternion_rate(start.q, start.w), load<T>(v.body.start_v_rate),
                           load<T>(v.body.start_w_rate)};
    store(v.body.sum, scale(T(weight), rates));
    place(v, add(start, T(h), rates));
  });
  const Auxiliary& x = ev.auxiliary;
  for (std::size_t i = 0; i < x.now.size(); ++i) {
    x.sum[i] = weight * x.first[i];
    x.now[i] = x.start[i] + h * x.first[i];
  }
}

// Adds `weight` of the present rates to the sum; the motion goes `h` seconds from the beginning along these rates.
template <int kWidest>
void advance_stage(const PlanData& plan, Evaluation& ev, double weight, double h) {
  for_bodies<kWidest>(plan, ev, [&]<class V>(const V v) {
    using T = typename V::T;
    const MotionT<T> rates = calc_rates(v);
    store(v.body.sum, add(load<T>(v.body.sum), T(weight), rates));
    place(v, add(load<T>(v.body.start), T(h), rates));
  });
  const Auxiliary& x = ev.auxiliary;
  for (std::size_t i = 0; i < x.now.size(); ++i) {
    x.sum[i] += weight * x.rate[i];
    x.now[i] = x.start[i] + h * x.rate[i];
  }
}

// Adds `weight` of the present rates to the sum; auxiliary states go `h` seconds from the beginning along the sum.
inline void finish_auxiliary(const Auxiliary& x, double weight, double h) {
  for (std::size_t i = 0; i < x.now.size(); ++i) {
    x.sum[i] += weight * x.rate[i];
    x.now[i] = x.start[i] + h * x.sum[i];
  }
}

// Adds `weight` of the present rates to the sum; the motion goes `h` seconds from the beginning along the sum.
template <int kWidest>
void finish_stages(const PlanData& plan, Evaluation& ev, double weight, double h) {
  for_bodies<kWidest>(plan, ev, [&]<class V>(const V v) {
    using T = typename V::T;
    const MotionT<T> sum = add(load<T>(v.body.sum), T(weight), calc_rates(v));
    MotionT<T> end = add(load<T>(v.body.start), T(h), sum);
    end.q = normalized(end.q);
    place(v, end);
  });
  finish_auxiliary(ev.auxiliary, weight, h);
}

// --- ROS2 ------------------------------------------------------------------------------------------------------------

// Back to the beginning.
template <int kWidest>
void restart(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, []<class V>(const V v) { place(v, load<typename V::T>(v.body.start)); });
  const Auxiliary& x = ev.auxiliary;
  for (std::size_t i = 0; i < x.now.size(); ++i) x.now[i] = x.start[i];
}

// With a = a1: x' = v + γh a, v' = a. Auxiliary states have such rates already (lead_modal_rates() in flexible.h).
template <int kWidest>
void finish_first_stage(const PlanData& plan, Evaluation& ev, double h, double gamma_h) {
  for_bodies<kWidest>(plan, ev, [&]<class V>(const V v) {
    using T = typename V::T;
    const MotionT<T> start = load<T>(v.body.start);
    MotionT<T> rates = calc_rates(v);
    rates.p = start.v + T(gamma_h) * rates.v;
    rates.q = quaternion_rate(start.q, start.w + T(gamma_h) * rates.w);
    store(v.body.sum, rates);
    place(v, add(start, T(h), rates));
  });
  const Auxiliary& x = ev.auxiliary;
  for (std::size_t i = 0; i < x.now.size(); ++i) {
    x.sum[i] = x.rate[i];
    x.now[i] = x.start[i] + h * x.rate[i];
  }
}

// With a = a2: x' = v + γh (a − 2 a1), v' = a; the quaternion's part of A stays that of the beginning. Then h/2 along
// the sum of both rates.
template <int kWidest>
void finish_second_stage(const PlanData& plan, Evaluation& ev, double h, double gamma_h) {
  for_bodies<kWidest>(plan, ev, [&]<class V>(const V v) {
    using T = typename V::T;
    const MotionT<T> start = load<T>(v.body.start), first = load<T>(v.body.sum);
    MotionT<T> rates = calc_rates(v);
    const QuatT<T> turn = quaternion_rate(start.q, T(gamma_h) * (rates.w - T(2) * first.w));
    rates.p = rates.p + T(gamma_h) * (rates.v - T(2) * first.v);
    rates.q = {rates.q.w + turn.w, rates.q.x + turn.x, rates.q.y + turn.y, rates.q.z + turn.z};
    MotionT<T> end = add(start, T(0.5 * h), add(first, T(1), rates));
    end.q = normalized(end.q);
    place(v, end);
  });
  finish_auxiliary(ev.auxiliary, 1, 0.5 * h);
}

// --- Corrections -----------------------------------------------------------------------------------------------------

// Applies the latest solution as a displacement.
template <int kWidest>
void add_displacements(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, []<class V>(const V v) {
    using T = typename V::T;
    const SpatialT<T> d = load<T>(v.shared.acceleration);
    const MotionT<T> now = load<T>(v.body.motion);
    const Vec3T<T> half = T(0.5) * d.ang;
    const QuatT<T> q = now.q;
    const QuatT<T> turn = QuatT<T>{T(0.0), half.x, half.y, half.z} * q;
    place(v, MotionT<T>{now.p + d.lin, normalized(QuatT<T>{q.w + turn.w, q.x + turn.x, q.y + turn.y, q.z + turn.z}),
                        now.v, now.w});
  });
}

// Applies the latest solution as a change of velocity; inertias stay.
template <int kWidest>
void add_velocities(const PlanData& plan, Evaluation& ev) {
  for_bodies<kWidest>(plan, ev, []<class V>(const V v) {
    using T = typename V::T;
    const SpatialT<T> d = load<T>(v.shared.acceleration);
    const Mat3T<T> R = load<T>(v.body.R);
    const Vec3T<T> w = load<T>(v.body.motion.w) + transpose_times(R, d.ang);
    store(v.body.motion.v, load<T>(v.body.motion.v) + d.lin);
    store(v.body.motion.w, w);
    store(v.body.w_W, R * w);
  });
}

}  // namespace unlatch::UNLATCH_ISA
