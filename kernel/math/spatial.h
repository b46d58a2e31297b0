// Spatial algebra of the tree solver: the block of a body and all beyond it, its downdate by one freedom, its way to
// the parent. World axes, at each body's own origin, so that passing on is a translation and never a rotation.
#pragma once

#include "unlatch/math.h"

namespace unlatch {

// 6×6 symmetric inertia of the bodies beyond a node: force = M a + H α, torque = Hᵀ a + I α, at the node's body origin.
template <class T>
struct ArticulatedT {
  Sym3T<T> M;
  Mat3T<T> H;
  Sym3T<T> I;
};
using Articulated = ArticulatedT<double>;

#define UNLATCH_INLINE __attribute__((always_inline)) inline
#define UNLATCH_INLINE_LAMBDA __attribute__((always_inline))

template <class T>
UNLATCH_INLINE SpatialT<T> operator+(const SpatialT<T>& a, const SpatialT<T>& b) {
  return {a.lin + b.lin, a.ang + b.ang};
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator-(const SpatialT<T>& a, const SpatialT<T>& b) {
  return {a.lin - b.lin, a.ang - b.ang};
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator*(const T& s, const SpatialT<T>& a) {
  return {s * a.lin, s * a.ang};
}
template <class T>
UNLATCH_INLINE T dot(const SpatialT<T>& a, const SpatialT<T>& b) {
  return dot(a.lin, b.lin) + dot(a.ang, b.ang);
}
// A wrench, given at a point `r` away from the origin, at the origin; a motion, given at the origin, at that point.
template <class T>
UNLATCH_INLINE SpatialT<T> shift_wrench(const SpatialT<T>& w, const Vec3T<T>& r) {
  return {w.lin, w.ang + cross(r, w.lin)};
}
template <class T>
UNLATCH_INLINE SpatialT<T> shift_motion(const SpatialT<T>& a, const Vec3T<T>& r) {
  return {a.lin + cross(a.ang, r), a.ang};
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator*(const ArticulatedT<T>& A, const SpatialT<T>& s) {
  return {A.M * s.lin + A.H * s.ang, transpose_times(A.H, s.lin) + A.I * s.ang};
}
template <class T>
UNLATCH_INLINE Sym3T<T> operator+(const Sym3T<T>& a, const Sym3T<T>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}

// The direction of a freedom that slides, or a force alone: what of a spatial vector is linear, the rest zero.
template <class T>
struct SlideT {
  Vec3T<T> lin;
};
template <class T>
UNLATCH_INLINE SlideT<T> operator*(const T& s, const SlideT<T>& a) {
  return {s * a.lin};
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator+(const SpatialT<T>& a, const SlideT<T>& b) {
  return {a.lin + b.lin, a.ang};
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator-(const SpatialT<T>& a, const SlideT<T>& b) {
  return {a.lin - b.lin, a.ang};
}
template <class T>
UNLATCH_INLINE T dot(const SlideT<T>& a, const SlideT<T>& b) {
  return dot(a.lin, b.lin);
}
template <class T>
UNLATCH_INLINE T dot(const SlideT<T>& a, const SpatialT<T>& b) {
  return dot(a.lin, b.lin);
}
template <class T>
UNLATCH_INLINE SpatialT<T> operator*(const ArticulatedT<T>& A, const SlideT<T>& s) {
  return {A.M * s.lin, transpose_times(A.H, s.lin)};
}

// A block without coupling, H = 0: of a body alone, and of what sliding freedoms leave of it.
template <class T>
struct UncoupledT {
  Sym3T<T> M, I;
};
template <class T>
UNLATCH_INLINE SpatialT<T> operator*(const UncoupledT<T>& A, const SpatialT<T>& s) {
  return {A.M * s.lin, A.I * s.ang};
}
template <class T>
UNLATCH_INLINE SlideT<T> operator*(const UncoupledT<T>& A, const SlideT<T>& s) {
  return {A.M * s.lin};
}

// Σ s_i² A_ii: how large sᵀ A s is before cancellation, within a factor of six.
template <class T>
UNLATCH_INLINE T calc_pivot_scale(const ArticulatedT<T>& A, const SpatialT<T>& s) {
  return ((A.M.xx * (s.lin.x * s.lin.x) + A.M.yy * (s.lin.y * s.lin.y)) + A.M.zz * (s.lin.z * s.lin.z)) +
         ((A.I.xx * (s.ang.x * s.ang.x) + A.I.yy * (s.ang.y * s.ang.y)) + A.I.zz * (s.ang.z * s.ang.z));
}

template <class T>
UNLATCH_INLINE T calc_pivot_scale(const ArticulatedT<T>& A, const SlideT<T>& s) {
  return (A.M.xx * (s.lin.x * s.lin.x) + A.M.yy * (s.lin.y * s.lin.y)) + A.M.zz * (s.lin.z * s.lin.z);
}

// s − (k a) aᵀ
template <class T>
UNLATCH_INLINE Sym3T<T> downdate(const Sym3T<T>& s, const Vec3T<T>& ka, const Vec3T<T>& a) {
  return {s.xx - ka.x * a.x, s.yy - ka.y * a.y, s.zz - ka.z * a.z,
          s.xy - ka.x * a.y, s.xz - ka.x * a.z, s.yz - ka.y * a.z};
}

// A − k U Uᵀ
template <class T>
UNLATCH_INLINE ArticulatedT<T> downdated(const ArticulatedT<T>& A, const T& k, const SpatialT<T>& U) {
  const Vec3T<T> kl = k * U.lin, ka = k * U.ang;
  return {downdate(A.M, kl, U.lin),
          {A.H.x - ka.x * U.lin, A.H.y - ka.y * U.lin, A.H.z - ka.z * U.lin},
          downdate(A.I, ka, U.ang)};
}
template <class T>
UNLATCH_INLINE ArticulatedT<T> downdated(const UncoupledT<T>& A, const T& k, const SpatialT<T>& U) {
  const Vec3T<T> kl = k * U.lin, ka = k * U.ang;
  return {downdate(A.M, kl, U.lin), {(-ka.x) * U.lin, (-ka.y) * U.lin, (-ka.z) * U.lin}, downdate(A.I, ka, U.ang)};
}
template <class T>
UNLATCH_INLINE UncoupledT<T> downdated(const UncoupledT<T>& A, const T& k, const SlideT<T>& U) {
  return {downdate(A.M, k * U.lin, U.lin), A.I};
}

// A, given at a point `r` away from the parent's origin, as the parent sees it: Xᵀ A X with a_point = a + α × r.
//   H' = H − M r̃,   I' = I + r̃ H' − Hᵀ r̃
template <class T>
UNLATCH_INLINE ArticulatedT<T> shift(const ArticulatedT<T>& A, const Vec3T<T>& r) {
  const Sym3T<T>& M = A.M;
  ArticulatedT<T> out;
  out.M = M;
  // columns of M r̃, with r̃ e_x = (0, r.z, −r.y), r̃ e_y = (−r.z, 0, r.x), r̃ e_z = (r.y, −r.x, 0)
  out.H.x = A.H.x - Vec3T<T>{M.xy * r.z - M.xz * r.y, M.yy * r.z - M.yz * r.y, M.yz * r.z - M.zz * r.y};
  out.H.y = A.H.y - Vec3T<T>{M.xz * r.x - M.xx * r.z, M.yz * r.x - M.xy * r.z, M.zz * r.x - M.xz * r.z};
  out.H.z = A.H.z - Vec3T<T>{M.xx * r.y - M.xy * r.x, M.xy * r.y - M.yy * r.x, M.xz * r.y - M.yz * r.x};
  const Vec3T<T>&hx = out.H.x, &hy = out.H.y, &hz = out.H.z;
  // r̃ H' by columns r × h; (Hᵀ r̃) by its needed entries h_i · (r̃ e_j)
  out.I.xx = (A.I.xx + (r.y * hx.z - r.z * hx.y)) - (A.H.x.y * r.z - A.H.x.z * r.y);
  out.I.yy = (A.I.yy + (r.z * hy.x - r.x * hy.z)) - (A.H.y.z * r.x - A.H.y.x * r.z);
  out.I.zz = (A.I.zz + (r.x * hz.y - r.y * hz.x)) - (A.H.z.x * r.y - A.H.z.y * r.x);
  out.I.xy = (A.I.xy + (r.y * hy.z - r.z * hy.y)) - (A.H.x.z * r.x - A.H.x.x * r.z);
  out.I.xz = (A.I.xz + (r.y * hz.z - r.z * hz.y)) - (A.H.x.x * r.y - A.H.x.y * r.x);
  out.I.yz = (A.I.yz + (r.z * hz.x - r.x * hz.z)) - (A.H.y.x * r.y - A.H.y.y * r.x);
  return out;
}

template <class T>
UNLATCH_INLINE ArticulatedT<T> operator+(const ArticulatedT<T>& A, const ArticulatedT<T>& B) {
  return {A.M + B.M, {A.H.x + B.H.x, A.H.y + B.H.y, A.H.z + B.H.z}, A.I + B.I};
}

// LDLᵀ of a symmetric 3×3: L⁻¹ = [1; −l10 1; n20 −l21 1] and the pivots' inverses.
template <class T>
struct Factor3T {
  T l10, n20, l21, i0, i1, i2;
};
template <class T>
UNLATCH_INLINE Vec3T<T> solve(const Factor3T<T>& f, const Vec3T<T>& b) {
  const T z = ((b.z + f.n20 * b.x) - f.l21 * b.y) * f.i2, y = (b.y - f.l10 * b.x) * f.i1;
  return {(b.x * f.i0 - f.l10 * y) + f.n20 * z, y - f.l21 * z, z};
}

// Block LDLᵀ of a whole articulated block, by linear and angular part: what a body that nothing holds needs.
template <class T>
struct FreeFactorT {
  Factor3T<T> M;  // of M
  Mat3T<T> W;     // M⁻¹ H
  Factor3T<T> K;  // of I − Hᵀ M⁻¹ H
};
using FreeFactor = FreeFactorT<double>;

}  // namespace unlatch
