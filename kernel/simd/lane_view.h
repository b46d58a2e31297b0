// One part of a group's block as vectors and matrices of packs. Compiled once per instruction set, see pack.h.
#pragma once

#include "kernel/plan/lane_access.h"
#include "kernel/plan/lanes.h"
#include "kernel/simd/pack.h"
#include "unlatch/plan.h"

namespace unlatch::UNLATCH_ISA {

// Rows of a group's and its octet's blocks, or of their constants in the same places, at some lanes of them. Those of
// bodies are kOctet apart, whatever the group's width.
template <class Pack, int kWidth, class Number = double>
struct View {
  using T = Pack;
  static constexpr int kStride = kWidth;  // known to the compiler, so that rows are plain displacements
  using Vec = Vec3T<T>;
  using Mat = Mat3T<T>;
  using Sym = Sym3T<T>;
  using Spa = SpatialT<T>;
  Number *data = nullptr, *joint = nullptr, *body = nullptr, *shared = nullptr;

  UNLATCH_INLINE Number* find(int row) const { return data + row * kStride; }
  UNLATCH_INLINE Number* find(JointField row) const { return joint + row * kStride; }
  UNLATCH_INLINE Number* find(JointConstant row) const { return joint + row * kStride; }
  UNLATCH_INLINE Number* find(BodyField row) const { return body + row * kOctet; }
  UNLATCH_INLINE Number* find(BodyConstant row) const { return body + row * kOctet; }
  UNLATCH_INLINE Number* find(SharedField row) const { return shared + row * kOctet; }
  // Its rows counted from this one on.
  UNLATCH_INLINE View from(int row) const { return {find(row)}; }
  UNLATCH_INLINE View<T, kOctet, Number> from(BodyField row) const { return {find(row)}; }

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

// One number of the parent for all lanes.
template <class Pack>
struct FanParent {
  using T = Pack;
  const double *body, *shared;

  UNLATCH_INLINE T get(BodyField row) const { return T(body[row * kOctet]); }
  UNLATCH_INLINE T get(SharedField row) const { return T(shared[row * kOctet]); }
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
UNLATCH_INLINE View<T, kWidth> get_view(const LaneGroup& group, double* lanes, int lane) {
  return {lanes + group.data + lane, lanes + group.joint + lane, lanes + group.body + lane,
          lanes + group.shared + lane};
}
template <class T, int kWidth>
UNLATCH_INLINE View<T, kWidth, const double> get_constants(const Plan& plan, const LaneGroup& group, int lane) {
  return {plan.solver_constants.data() + kSolverConstants * group.first + lane,
          plan.joint_constants.data() + group.constants + lane};
}

// Rows of the parents' bodies, lane by lane. Neighbouring parents are neighbours in their octet.
template <class Pack>
struct Parents {
  LaneLink link;
  const double* lanes;
  const LaneSlot* slots;

  // read(source of rows): the way to them is chosen once.
  template <class Read>
  UNLATCH_INLINE auto visit(const Read& read) const {
    const double *body = lanes + slots[0].body, *shared = lanes + slots[0].shared;
    if (link == LaneLink::kContiguous) return read(View<Pack, kOctet, const double>{nullptr, nullptr, body, shared});
    if (link == LaneLink::kFan) return read(FanParent<Pack>{body, shared});
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
