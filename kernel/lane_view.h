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

// One number of the parent for all lanes.
template <class Pack>
struct FanParent {
  using T = Pack;
  const double* data;
  std::int32_t stride;

  UNLATCH_INLINE T get(int row) const { return T(data[row * stride]); }
};
// Parents wherever they are.
template <class Pack>
struct GatheredParents {
  using T = Pack;
  const double* lanes;
  const LaneSlot* slots;

  UNLATCH_INLINE T get(int row) const {
    double out[T::kWidth];
    for (int i = 0; i < T::kWidth; ++i) out[i] = lanes[slots[i].offset + row * slots[i].stride];
    return load<T>(out);
  }
};

// Rows of the parents, lane by lane. Neighbouring parents are in a group of the same width.
template <class Pack, int kWidth>
struct Parents {
  LaneLink link;
  const double* lanes;
  const LaneSlot* slots;

  // read(source of rows): the way to them is chosen once.
  template <class Read>
  UNLATCH_INLINE auto visit(const Read& read) const {
    if (link == LaneLink::kContiguous) return read(View<Pack, kWidth, const double>{lanes + slots[0].offset});
    if (link == LaneLink::kFan) return read(FanParent<Pack>{lanes + slots[0].offset, slots[0].stride});
    return read(GatheredParents<Pack>{lanes, slots});
  }
};

// Consecutive rows of a source.
template <class Source, class T = typename Source::T>
UNLATCH_INLINE Vec3T<T> get_vec(const Source& from, int row) {
  return {from.get(row), from.get(row + 1), from.get(row + 2)};
}
template <class Source, class T = typename Source::T>
UNLATCH_INLINE SpatialT<T> get_spatial(const Source& from, int row) {
  return {get_vec(from, row), get_vec(from, row + 3)};
}
template <class Source, class T = typename Source::T>
UNLATCH_INLINE Mat3T<T> get_mat(const Source& from, int row) {
  return {get_vec(from, row), get_vec(from, row + 3), get_vec(from, row + 6)};
}

}  // namespace unlatch::UNLATCH_ISA
