// One part of a group's block as vectors and matrices of packs. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/lanes.h"
#include "kernel/pack.h"

namespace unlatch::UNLATCH_ISA {

// Rows of a block, or of a constant's block, at some lanes of it.
template <class Pack, int kWidth, class Number = double>
struct View {
  using T = Pack;
  static constexpr int kStride = kWidth;  // of the group: known to the compiler, so that rows are plain displacements
  using Vec = Vec3T<T>;
  using Mat = Mat3T<T>;
  using Sym = Sym3T<T>;
  using Spa = SpatialT<T>;
  Number* data;

  UNLATCH_INLINE View from(int row) const { return {data + row * kStride}; }
  UNLATCH_INLINE T get(int row) const { return load<T>(data + row * kStride); }
  UNLATCH_INLINE Vec get_vec(int row) const { return {get(row), get(row + 1), get(row + 2)}; }
  UNLATCH_INLINE Spa get_spatial(int row) const { return {get_vec(row), get_vec(row + 3)}; }
  UNLATCH_INLINE Mat get_mat(int row) const { return {get_vec(row), get_vec(row + 3), get_vec(row + 6)}; }
  UNLATCH_INLINE Sym get_sym(int row) const {
    return {get(row), get(row + 1), get(row + 2), get(row + 3), get(row + 4), get(row + 5)};
  }
  UNLATCH_INLINE QuatT<T> get_quat(int row) const { return {get(row), get(row + 1), get(row + 2), get(row + 3)}; }

  UNLATCH_INLINE void set(int row, const T& a) const { store(data + row * kStride, a); }
  UNLATCH_INLINE void set(int row, const Vec& a) const {
    set(row, a.x);
    set(row + 1, a.y);
    set(row + 2, a.z);
  }
  UNLATCH_INLINE void set(int row, const Spa& a) const {
    set(row, a.lin);
    set(row + 3, a.ang);
  }
  UNLATCH_INLINE void set(int row, const Mat& m) const {
    set(row, m.x);
    set(row + 3, m.y);
    set(row + 6, m.z);
  }
  UNLATCH_INLINE void set(int row, const Sym& s) const {
    set(row, s.xx);
    set(row + 1, s.yy);
    set(row + 2, s.zz);
    set(row + 3, s.xy);
    set(row + 4, s.xz);
    set(row + 5, s.yz);
  }
  UNLATCH_INLINE void set(int row, const QuatT<T>& q) const {
    set(row, q.w);
    set(row + 1, q.x);
    set(row + 2, q.y);
    set(row + 3, q.z);
  }
};

// Rows of the parents, lane by lane. Neighbouring parents are in a group of the same width.
template <class Pack, int kWidth>
struct Parents {
  using T = Pack;
  LaneLink link;
  const double* lanes;
  const LaneSlot* slots;

  UNLATCH_INLINE T get(int row) const {
    const LaneSlot& first = slots[0];
    if (link == LaneLink::kFan) return T(lanes[first.offset + row * first.stride]);
    if (link == LaneLink::kContiguous) return load<T>(lanes + first.offset + row * kWidth);
    double out[T::kWidth];
    for (int i = 0; i < T::kWidth; ++i) out[i] = lanes[slots[i].offset + row * slots[i].stride];
    return load<T>(out);
  }
  UNLATCH_INLINE Vec3T<T> get_vec(int row) const { return {get(row), get(row + 1), get(row + 2)}; }
  UNLATCH_INLINE SpatialT<T> get_spatial(int row) const { return {get_vec(row), get_vec(row + 3)}; }
  UNLATCH_INLINE Mat3T<T> get_mat(int row) const { return {get_vec(row), get_vec(row + 3), get_vec(row + 6)}; }
};

}  // namespace unlatch::UNLATCH_ISA
