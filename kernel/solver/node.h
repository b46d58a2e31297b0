// One body of the tree in the solver: its block and wrench, its joint's freedoms and rows, and the factor of a block
// that nothing holds. Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/plan/group_view.h"
#include "kernel/solver/sweep.h"

namespace unlatch::UNLATCH_ISA {

// A pivot that the elimination of the joint's other freedoms has reduced by this factor is rounding noise.
inline constexpr double kVanishing = 1e-13;

// Calls use(direction) with the direction of freedom r at the child's origin, whose type is that of its kind.
template <class V, class Use, class T = typename V::T>
UNLATCH_INLINE auto with_freedom(const V& v, int r, const Use& use) {
  const Vec3T<T> axis = v.get_axis(r);
  if (r < kRotX) return use(SlideT<T>{axis});
  return use(SpatialT<T>{cross(load<T>(v.blocks.solver().arm_child), axis), axis});
}
// Wrench of row r on the child, at its origin.
template <class V, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> get_row_wrench(const V& v, int r) {
  const Vec3T<T> axis = v.get_axis(r);
  const T o(0.0);
  if (r < kRotX) return {axis, cross(load<T>(v.blocks.solver().arm_child), axis)};
  return {{o, o, o}, axis};
}
template <class V, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> get_bias(const V& v, bool biased) {
  const T o(0.0);
  return biased && v.group.has_joint ? load<T>(v.blocks.solver().bias) : SpatialT<T>{{o, o, o}, {o, o, o}};
}

template <class V, class T = typename V::T>
UNLATCH_INLINE SpatialT<T> get_own_wrench(const V& v, Source source) {
  if (source != Source::kNothing) return load<T>(v.blocks.shared().force);
  const T o(0.0);
  return {{o, o, o}, {o, o, o}};
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

// --- The block of a body that nothing, or little, holds --------------------------------------------------------------

// LDLᵀ of a symmetric 3×3, from its minors, so that its divisions do not wait for each other. As accurate as one pivot
// after the other, since each minor is the pivot times the pivots before it. `bad`: lanes where a pivot vanished
// relative to its diagonal entry in `whole`.
template <class T>
UNLATCH_INLINE Factor3T<T> factor3(const Sym3T<T>& s, const Sym3T<T>& whole, T& bad) {
  const T minor = s.xx * s.yy - s.xy * s.xy, e = s.xx * s.yz - s.xy * s.xz, last = s.xx * s.zz - s.xz * s.xz;
  const T scale = s.xx * minor, rest = last * minor - e * e;
  const T tiny(kVanishing), i0 = T(1) / s.xx, by_minor = T(1) / minor;
  // The least of the three remainders; the last is NaN if one of the others is.
  const T first = s.xx - tiny * whole.xx, second = minor - tiny * (s.xx * whole.yy),
          third = rest - tiny * (scale * whole.zz);
  bad = bad | ~(min(min(first, second), third) > T(0.0));
  const T l10 = s.xy * i0, l21 = e * by_minor;
  return {l10, l10 * l21 - s.xz * i0, l21, i0, s.xx * by_minor, scale / rest};
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

// --- The body's block and wrench
// ---------------------------------------------------------------------------------------

// With what its children have added. A leaf's block is diag(mass, I).
template <class T, bool kLeaf>
struct Node;

template <class T>
struct Node<T, true> {
  T mass;
  Sym3T<T> I;
  SpatialT<T> wrench;

  template <int kWidth>
  UNLATCH_INLINE Node(const GroupView<T, kWidth>& v, Source source)
      : mass(load<T>(v.constants.solver().mass)),
        I(load<T>(v.blocks.shared().inertia)),
        wrench(get_own_wrench(v, source)) {}
  UNLATCH_INLINE SpatialT<T> times(const SpatialT<T>& a) const { return {mass * a.lin, I * a.ang}; }
  UNLATCH_INLINE SlideT<T> times(const SlideT<T>& a) const { return {mass * a.lin}; }
  UNLATCH_INLINE ArticulatedT<T> get_block() const { return get_body_block(mass, I); }
  // A − k U Uᵀ
  UNLATCH_INLINE ArticulatedT<T> downdated(const T& k, const SpatialT<T>& U) const {
    const Vec3T<T> kl = k * U.lin, ka = k * U.ang;
    return {downdated_mass(kl, U.lin), {(-ka.x) * U.lin, (-ka.y) * U.lin, (-ka.z) * U.lin}, downdate(I, ka, U.ang)};
  }
  UNLATCH_INLINE UncoupledT<T> downdated(const T& k, const SlideT<T>& U) const {
    return {downdated_mass(k * U.lin, U.lin), I};
  }
  // A⁻¹ by parts, if nothing holds the body.
  UNLATCH_INLINE FreeFactorT<T> factor(T& bad) const {
    const T o(0.0), inverse = T(1) / mass;
    return {{o, o, o, inverse, inverse, inverse}, {{o, o, o}, {o, o, o}, {o, o, o}}, factor3(I, I, bad)};
  }
  UNLATCH_INLINE SpatialT<T> solve(const FreeFactorT<T>& f, const SpatialT<T>& b) const {
    return {f.M.i0 * b.lin, unlatch::solve(f.K, b.ang)};
  }
  // False only where something is not finite: a leaf's block has not been reduced.
  template <class S>
  UNLATCH_INLINE T is_pivot(const T& pivot, const S&) const {
    return pivot > T(0.0);
  }

 private:
  UNLATCH_INLINE Sym3T<T> downdated_mass(const Vec3T<T>& ka, const Vec3T<T>& a) const {
    return {mass - ka.x * a.x, mass - ka.y * a.y, mass - ka.z * a.z, -(ka.x * a.y), -(ka.x * a.z), -(ka.y * a.z)};
  }
};

template <class T>
struct Node<T, false> {
  ArticulatedT<T> A;
  SpatialT<T> wrench;

  template <int kWidth>
  UNLATCH_INLINE Node(const GroupView<T, kWidth>& v, Source)
      : A(load<T>(v.blocks.subtree().A)), wrench(load<T>(v.blocks.subtree().wrench)) {}
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
    return pivot > T(kVanishing) * calc_pivot_scale(A, s);
  }
};

// The first lane whose pivot vanished, as a node.
template <class T>
inline int find_bad_node(const PlanData& plan, const Group& group, int lane, const T& bad) {
  std::int64_t bits[T::kWidth];
  __builtin_memcpy(bits, &bad.v, sizeof(bits));
  for (int i = 0; i < T::kWidth; ++i)
    if (bits[i] != 0) return plan.lane_nodes[static_cast<std::size_t>(group.first + lane + i)];
  return kNone;
}

}  // namespace unlatch::UNLATCH_ISA
