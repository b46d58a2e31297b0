// One body of the tree as the solver sees it, on lanes: its block, its load, its joint's freedoms and rows, and the
// factor of a block that nothing holds. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/dynamics/lane_motion.h"

namespace unlatch::UNLATCH_ISA {

// A pivot this small beside what it was before the joint's other freedoms were taken out is rounding noise.
inline constexpr double kSingular = 1e-13;

// What one group is worked on with: its lanes from `lane` on.
template <class T, int kWidth>
struct Part {
  const Plan& plan;
  Workspace& ws;
  const LaneGroup& group;
  const LanePhase& phase;
  double* lanes;
  int lane;
  const LaneSlot* parents;
  View<T, kWidth> v;
  View<T, kWidth, const double> c;

  UNLATCH_INLINE Part(const Plan& of, Workspace& in, std::size_t g, int first)
      : plan(of),
        ws(in),
        group(plan.groups[g]),
        phase(ws.phases[g]),
        lanes(ws.lanes.data()),
        lane(first),
        parents(plan.lane_parents.data() + group.first + first),
        v(get_view<T, kWidth>(group, lanes, first)),
        c(get_constants<T, kWidth>(plan, group, first)) {}

  UNLATCH_INLINE Vec3T<T> get_axis(int r) const {
    return v.get_vec(r < kRotX ? kAxes + 3 * r : group.rotation_axes + 3 * (r - kRotX));
  }
  // Direction of freedom r at the child's origin, by what it is. Hands it to use(direction).
  template <class Use>
  UNLATCH_INLINE auto with_freedom(int r, const Use& use) const {
    const Vec3T<T> axis = get_axis(r);
    if (r < kRotX) return use(SlideT<T>{axis});
    return use(SpatialT<T>{cross(v.get_vec(kArmChild), axis), axis});
  }
  // Wrench of row r on the child, at its origin.
  UNLATCH_INLINE SpatialT<T> get_wrench(int r) const {
    const Vec3T<T> axis = get_axis(r);
    const T o(0.0);
    if (r < kRotX) return {axis, cross(v.get_vec(kArmChild), axis)};
    return {{o, o, o}, axis};
  }
  UNLATCH_INLINE SpatialT<T> get_bias(bool biased) const {
    const T o(0.0);
    return biased && group.has_joint ? v.get_spatial(kBias) : SpatialT<T>{{o, o, o}, {o, o, o}};
  }
};

template <class V, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> get_source(const V& v, Source source) {
  if (source == Source::kForces) return v.get_spatial(kForce);
  if (source == Source::kGiven) return v.get_spatial(kAcceleration);
  const T o(0.0);
  return {{o, o, o}, {o, o, o}};
}

template <class V, class T = typename V::T>
UNLATCH_INLINE ArticulatedT<T> get_block(const V& v) {
  return {v.get_sym(0), v.get_mat(6), v.get_sym(15)};
}
template <class V, class T = typename V::T>
UNLATCH_INLINE void set_block(const V& v, const ArticulatedT<T>& A) {
  v.set(0, A.M);
  v.set(6, A.H);
  v.set(15, A.I);
}

template <class T>
UNLATCH_INLINE const ArticulatedT<T>& get_whole(const ArticulatedT<T>& A) {
  return A;
}
template <class T>
UNLATCH_INLINE ArticulatedT<T> get_whole(const UncoupledT<T>& A) {
  const T o(0.0);
  return {A.M, {{o, o, o}, {o, o, o}, {o, o, o}}, A.I};
}
template <class T>
UNLATCH_INLINE ArticulatedT<T> get_body_block(const T& mass, const Sym3T<T>& inertia) {
  const T o(0.0);
  return {{mass, mass, mass, o, o, o}, {{o, o, o}, {o, o, o}, {o, o, o}}, inertia};
}

// --- The block of a body that nothing, or little, holds -------------------------------------------------------------

// LDLᵀ of a symmetric 3×3, from its minors, so that its divisions do not wait for each other. As accurate as one pivot
// after the other: what is subtracted and what is left keep their proportions. `bad`: lanes where a pivot vanished
// beside the diagonal entry that it came from.
template <class T>
UNLATCH_INLINE Factor3T<T> factor3(const Sym3T<T>& s, const Sym3T<T>& whole, T& bad) {
  const T minor = s.xx * s.yy - s.xy * s.xy, e = s.xx * s.yz - s.xy * s.xz, last = s.xx * s.zz - s.xz * s.xz;
  const T scale = s.xx * minor, rest = last * minor - e * e;
  const T tiny(kSingular), i0 = T(1) / s.xx, by_minor = T(1) / minor;
  // The least of what is left over; the last of them is no number if one of the others is not.
  const T first = s.xx - tiny * whole.xx, second = minor - tiny * (s.xx * whole.yy),
          third = rest - tiny * (scale * whole.zz);
  bad = bad | ~(min(min(first, second), third) > T(0.0));
  const T l10 = s.xy * i0, l21 = e * by_minor;
  return {l10, l10 * l21 - s.xz * i0, l21, i0, s.xx * by_minor, scale / rest};
}

template <class V, class T = typename V::T>
UNLATCH_INLINE void set_factor(const V& v, const FreeFactorT<T>& f) {
  v.set(0, Vec3T<T>{f.M.l10, f.M.n20, f.M.l21});
  v.set(3, Vec3T<T>{f.M.i0, f.M.i1, f.M.i2});
  v.set(6, f.W);
  v.set(15, Vec3T<T>{f.K.l10, f.K.n20, f.K.l21});
  v.set(18, Vec3T<T>{f.K.i0, f.K.i1, f.K.i2});
}
template <class V, class T = typename V::T>
UNLATCH_INLINE FreeFactorT<T> get_factor(const V& v) {
  return {{v.get(0), v.get(1), v.get(2), v.get(3), v.get(4), v.get(5)},
          v.get_mat(6),
          {v.get(15), v.get(16), v.get(17), v.get(18), v.get(19), v.get(20)}};
}

template <class T>
UNLATCH_INLINE FreeFactorT<T> factor_free(const ArticulatedT<T>& A, T& bad) {
  FreeFactorT<T> f;
  f.M = factor3(A.M, A.M, bad);
  f.W = {solve(f.M, A.H.x), solve(f.M, A.H.y), solve(f.M, A.H.z)};
  const Mat3T<T>& W = f.W;
  const Sym3T<T> K{A.I.xx - dot(A.H.x, W.x), A.I.yy - dot(A.H.y, W.y), A.I.zz - dot(A.H.z, W.z),
                   A.I.xy - dot(A.H.x, W.y), A.I.xz - dot(A.H.x, W.z), A.I.yz - dot(A.H.y, W.z)};
  f.K = factor3(K, A.I, bad);
  return f;
}

// A⁻¹ b = (y − W α, α) with α = K⁻¹ (b.ang − Wᵀ b.lin), y = M⁻¹ b.lin.
template <class T>
UNLATCH_INLINE SpatialT<T> solve_free(const FreeFactorT<T>& f, const SpatialT<T>& b) {
  const Vec3T<T> ang = solve(f.K, b.ang - transpose_times(f.W, b.lin));
  return {solve(f.M, b.lin) - f.W * ang, ang};
}

// --- The body's block and load --------------------------------------------------------------------------------------

// With what its children have added. A leaf's block is diag(mass, I).
template <class T, bool kLeaf>
struct Node;

template <class T>
struct Node<T, true> {
  T mass;
  Sym3T<T> I;
  SpatialT<T> load;

  template <int kWidth>
  UNLATCH_INLINE Node(const Part<T, kWidth>& part, Source source)
      : mass(part.c.get(kMass)), I(part.v.get_sym(kInertia)), load(get_source(part.v, source)) {}
  UNLATCH_INLINE SpatialT<T> times(const SpatialT<T>& a) const { return {mass * a.lin, I * a.ang}; }
  UNLATCH_INLINE SlideT<T> times(const SlideT<T>& a) const { return {mass * a.lin}; }
  UNLATCH_INLINE ArticulatedT<T> get_block() const { return get_body_block(mass, I); }
  // A − k U Uᵀ
  UNLATCH_INLINE ArticulatedT<T> downdated(const T& k, const SpatialT<T>& U) const {
    const Vec3T<T> kl = k * U.lin, ka = k * U.ang;
    return {{mass - kl.x * U.lin.x, mass - kl.y * U.lin.y, mass - kl.z * U.lin.z, -(kl.x * U.lin.y), -(kl.x * U.lin.z),
             -(kl.y * U.lin.z)},
            {(-ka.x) * U.lin, (-ka.y) * U.lin, (-ka.z) * U.lin},
            downdate(I, ka, U.ang)};
  }
  UNLATCH_INLINE UncoupledT<T> downdated(const T& k, const SlideT<T>& U) const {
    const Vec3T<T> kl = k * U.lin;
    return {{mass - kl.x * U.lin.x, mass - kl.y * U.lin.y, mass - kl.z * U.lin.z, -(kl.x * U.lin.y), -(kl.x * U.lin.z),
             -(kl.y * U.lin.z)},
            I};
  }
  // A⁻¹ by parts, if nothing holds the body.
  UNLATCH_INLINE FreeFactorT<T> factor(T& bad) const {
    const T o(0.0), inverse = T(1) / mass;
    return {{o, o, o, inverse, inverse, inverse}, {{o, o, o}, {o, o, o}, {o, o, o}}, factor3(I, I, bad)};
  }
  UNLATCH_INLINE SpatialT<T> solve(const FreeFactorT<T>& f, const SpatialT<T>& b) const {
    return {f.M.i0 * b.lin, unlatch::solve(f.K, b.ang)};
  }
  // False only where something is not finite: nothing has been taken out of it.
  template <class S>
  UNLATCH_INLINE T is_pivot(const T& pivot, const S&) const {
    return pivot > T(0.0);
  }
};

template <class T>
struct Node<T, false> {
  ArticulatedT<T> A;
  SpatialT<T> load;

  template <int kWidth>
  UNLATCH_INLINE Node(const Part<T, kWidth>& part, Source)
      : A(unlatch::UNLATCH_ISA::get_block(part.v.from(kBlock))), load(part.v.get_spatial(kBlock + 21)) {}
  template <class S>
  UNLATCH_INLINE SpatialT<T> times(const S& a) const {
    return A * a;
  }
  UNLATCH_INLINE const ArticulatedT<T>& get_block() const { return A; }
  UNLATCH_INLINE FreeFactorT<T> factor(T& bad) const { return factor_free(A, bad); }
  UNLATCH_INLINE SpatialT<T> solve(const FreeFactorT<T>& f, const SpatialT<T>& b) const { return solve_free(f, b); }
  UNLATCH_INLINE ArticulatedT<T> downdated(const T& k, const SpatialT<T>& U) const {
    return unlatch::downdated(A, k, U);
  }
  template <class S>
  UNLATCH_INLINE T is_pivot(const T& pivot, const S& s) const {
    return pivot > T(kSingular) * calc_pivot_scale(A, s);
  }
};

}  // namespace unlatch::UNLATCH_ISA
