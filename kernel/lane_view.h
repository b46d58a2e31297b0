// One part of a group's block as vectors and matrices of packs. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/lane_access.h"
#include "kernel/lanes.h"
#include "kernel/pack.h"
#include "kernel/plan.h"

namespace unlatch::UNLATCH_ISA {

// Rows of a group's blocks, or of its constants, at some lanes of it.
template <class Pack, int kWidth, class Number = double>
struct View {
  using T = Pack;
  static constexpr int kStride = kWidth;  // of the group: known to the compiler, so that rows are plain displacements
  using Vec = Vec3T<T>;
  using Mat = Mat3T<T>;
  using Sym = Sym3T<T>;
  using Spa = SpatialT<T>;
  Number *data, *motion;

  UNLATCH_INLINE Number* find(int row) const { return data + row * kStride; }
  UNLATCH_INLINE Number* find(MotionField row) const { return motion + row * kStride; }
  UNLATCH_INLINE Number* find(MotionConstant row) const { return motion + row * kStride; }
  // Its rows counted from this one on.
  template <class Row>
  UNLATCH_INLINE View from(Row row) const {
    return {find(row), nullptr};
  }

  template <class Row>
  UNLATCH_INLINE T get(Row row) const {
    return load<T>(find(row));
  }
  template <class Row>
  UNLATCH_INLINE Vec get_vec(Row row) const {
    return {get(row), get(row + 1), get(row + 2)};
  }
  template <class Row>
  UNLATCH_INLINE Spa get_spatial(Row row) const {
    return {get_vec(row), get_vec(row + 3)};
  }
  template <class Row>
  UNLATCH_INLINE Mat get_mat(Row row) const {
    return {get_vec(row), get_vec(row + 3), get_vec(row + 6)};
  }
  template <class Row>
  UNLATCH_INLINE Sym get_sym(Row row) const {
    return {get(row), get(row + 1), get(row + 2), get(row + 3), get(row + 4), get(row + 5)};
  }
  template <class Row>
  UNLATCH_INLINE QuatT<T> get_quat(Row row) const {
    return {get(row), get(row + 1), get(row + 2), get(row + 3)};
  }

  template <class Row>
  UNLATCH_INLINE void set(Row row, const T& a) const {
    store(find(row), a);
  }
  template <class Row>
  UNLATCH_INLINE void set(Row row, const Vec& a) const {
    set(row, a.x);
    set(row + 1, a.y);
    set(row + 2, a.z);
  }
  template <class Row>
  UNLATCH_INLINE void set(Row row, const Spa& a) const {
    set(row, a.lin);
    set(row + 3, a.ang);
  }
  template <class Row>
  UNLATCH_INLINE void set(Row row, const Mat& m) const {
    set(row, m.x);
    set(row + 3, m.y);
    set(row + 6, m.z);
  }
  template <class Row>
  UNLATCH_INLINE void set(Row row, const Sym& s) const {
    set(row, s.xx);
    set(row + 1, s.yy);
    set(row + 2, s.zz);
    set(row + 3, s.xy);
    set(row + 4, s.xz);
    set(row + 5, s.yz);
  }
  template <class Row>
  UNLATCH_INLINE void set(Row row, const QuatT<T>& q) const {
    set(row, q.w);
    set(row + 1, q.x);
    set(row + 2, q.y);
    set(row + 3, q.z);
  }
};

// One number of the parent for all lanes. The parent is mostly alone in its group, and its rows side by side.
template <class Pack, bool kAlone>
struct FanParent {
  using T = Pack;
  const double *data, *motion;
  std::ptrdiff_t stride;

  UNLATCH_INLINE FanParent(const double* lanes, const LaneSlot& slot)
      : data(lanes + slot.offset), motion(lanes + slot.motion), stride(kAlone ? 1 : slot.stride) {}
  UNLATCH_INLINE T get(int row) const { return T(data[row * (kAlone ? 1 : stride)]); }
  UNLATCH_INLINE T get(MotionField row) const { return T(motion[row * (kAlone ? 1 : stride)]); }
};
// Parents wherever they are.
template <class Pack>
struct GatheredParents {
  using T = Pack;
  const double* lanes;
  const LaneSlot* slots;

  template <class Row>
  UNLATCH_INLINE T get(Row row) const {
    return gather<T>([&](int i) { return lanes[find(slots[i], row)]; });
  }
};

template <class T, int kWidth>
UNLATCH_INLINE View<T, kWidth, const double> get_constants(const Plan& plan, const LaneGroup& group, int lane) {
  return {plan.solver_constants.data() + kSolverConstants * group.first + lane,
          plan.lane_constants.data() + group.constants + lane};
}

// Rows of the parents, lane by lane. Neighbouring parents are in a group of the same width.
template <class Pack, int kWidth>
struct Parents {
  LaneLink link;
  const double* lanes;
  const LaneSlot* slots;

  // read(source of rows): the way to them is chosen once.
  template <class Read>
  UNLATCH_INLINE auto visit(const Read& read) const {
    if (link == LaneLink::kContiguous)
      return read(View<Pack, kWidth, const double>{lanes + slots[0].offset, lanes + slots[0].motion});
    if (link == LaneLink::kFan && slots[0].stride == 1) return read(FanParent<Pack, true>(lanes, slots[0]));
    if (link == LaneLink::kFan) return read(FanParent<Pack, false>(lanes, slots[0]));
    return read(GatheredParents<Pack>{lanes, slots});
  }
};

// Consecutive rows of a source.
template <class Source, class Row, class T = typename Source::T>
UNLATCH_INLINE Vec3T<T> get_vec(const Source& from, Row row) {
  return {from.get(row), from.get(row + 1), from.get(row + 2)};
}
template <class Source, class Row, class T = typename Source::T>
UNLATCH_INLINE SpatialT<T> get_spatial(const Source& from, Row row) {
  return {get_vec(from, row), get_vec(from, row + 3)};
}
template <class Source, class Row, class T = typename Source::T>
UNLATCH_INLINE Mat3T<T> get_mat(const Source& from, Row row) {
  return {get_vec(from, row), get_vec(from, row + 3), get_vec(from, row + 6)};
}

}  // namespace unlatch::UNLATCH_ISA
