// Packs from memory and back: load<T>() of a number, vector or matrix of Wide numbers gives the same of packs, store()
// is its inverse. Reads T::kWidth neighbours from the first lane of what it is given. Compiled once per instruction
// set, see pack.h.
#pragma once

#include "kernel/math/spatial.h"
#include "kernel/simd/pack.h"
#include "kernel/simd/wide.h"

namespace unlatch::UNLATCH_ISA {

template <class T, int W>
UNLATCH_INLINE T load(const Wide<W>& a) {
  return load<T>(a.lane);
}
template <class T, int W>
UNLATCH_INLINE Vec3T<T> load(const Vec3T<Wide<W>>& a) {
  return {load<T>(a.x), load<T>(a.y), load<T>(a.z)};
}
template <class T, int W>
UNLATCH_INLINE QuatT<T> load(const QuatT<Wide<W>>& a) {
  return {load<T>(a.w), load<T>(a.x), load<T>(a.y), load<T>(a.z)};
}
template <class T, int W>
UNLATCH_INLINE Mat3T<T> load(const Mat3T<Wide<W>>& a) {
  return {load<T>(a.x), load<T>(a.y), load<T>(a.z)};
}
template <class T, int W>
UNLATCH_INLINE Sym3T<T> load(const Sym3T<Wide<W>>& a) {
  return {load<T>(a.xx), load<T>(a.yy), load<T>(a.zz), load<T>(a.xy), load<T>(a.xz), load<T>(a.yz)};
}
template <class T, int W>
UNLATCH_INLINE SpatialT<T> load(const SpatialT<Wide<W>>& a) {
  return {load<T>(a.lin), load<T>(a.ang)};
}
template <class T, int W>
UNLATCH_INLINE ArticulatedT<T> load(const ArticulatedT<Wide<W>>& a) {
  return {load<T>(a.M), load<T>(a.H), load<T>(a.I)};
}
template <class T, int W>
UNLATCH_INLINE Factor3T<T> load(const Factor3T<Wide<W>>& a) {
  return {load<T>(a.l10), load<T>(a.n20), load<T>(a.l21), load<T>(a.i0), load<T>(a.i1), load<T>(a.i2)};
}
template <class T, int W>
UNLATCH_INLINE FreeFactorT<T> load(const FreeFactorT<Wide<W>>& a) {
  return {load<T>(a.M), load<T>(a.W), load<T>(a.K)};
}

template <class T, int W>
UNLATCH_INLINE void store(Wide<W>& to, const T& a) {
  store(to.lane, a);
}
template <class T, int W>
UNLATCH_INLINE void store(Vec3T<Wide<W>>& to, const Vec3T<T>& a) {
  store(to.x, a.x);
  store(to.y, a.y);
  store(to.z, a.z);
}
template <class T, int W>
UNLATCH_INLINE void store(QuatT<Wide<W>>& to, const QuatT<T>& a) {
  store(to.w, a.w);
  store(to.x, a.x);
  store(to.y, a.y);
  store(to.z, a.z);
}
template <class T, int W>
UNLATCH_INLINE void store(Mat3T<Wide<W>>& to, const Mat3T<T>& a) {
  store(to.x, a.x);
  store(to.y, a.y);
  store(to.z, a.z);
}
template <class T, int W>
UNLATCH_INLINE void store(Sym3T<Wide<W>>& to, const Sym3T<T>& a) {
  store(to.xx, a.xx);
  store(to.yy, a.yy);
  store(to.zz, a.zz);
  store(to.xy, a.xy);
  store(to.xz, a.xz);
  store(to.yz, a.yz);
}
template <class T, int W>
UNLATCH_INLINE void store(SpatialT<Wide<W>>& to, const SpatialT<T>& a) {
  store(to.lin, a.lin);
  store(to.ang, a.ang);
}
template <class T, int W>
UNLATCH_INLINE void store(ArticulatedT<Wide<W>>& to, const ArticulatedT<T>& a) {
  store(to.M, a.M);
  store(to.H, a.H);
  store(to.I, a.I);
}
template <class T, int W>
UNLATCH_INLINE void store(Factor3T<Wide<W>>& to, const Factor3T<T>& a) {
  store(to.l10, a.l10);
  store(to.n20, a.n20);
  store(to.l21, a.l21);
  store(to.i0, a.i0);
  store(to.i1, a.i1);
  store(to.i2, a.i2);
}
template <class T, int W>
UNLATCH_INLINE void store(FreeFactorT<Wide<W>>& to, const FreeFactorT<T>& a) {
  store(to.M, a.M);
  store(to.W, a.W);
  store(to.K, a.K);
}

}  // namespace unlatch::UNLATCH_ISA
