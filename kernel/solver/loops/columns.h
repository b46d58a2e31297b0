// Numbers of several rows of loops side by side, so that these are computed at once: a column for each row of a loop.
// Compiled once per instruction set, see kernel/simd/pack.h.
#pragma once

#include "kernel/math/spatial.h"
#include "kernel/plan/lanes.h"
#include "kernel/simd/pack.h"

namespace unlatch::UNLATCH_ISA {

template <class T>
UNLATCH_INLINE Vec3T<T> spread(const Vec3& a) {
  return {T(a.x), T(a.y), T(a.z)};
}
template <class T>
UNLATCH_INLINE SpatialT<T> spread(const Spatial& a) {
  return {spread<T>(a.lin), spread<T>(a.ang)};
}

// Calls run(c) for every pack of the first `count` columns.
template <class T, class Run>
UNLATCH_INLINE void for_packs(int count, const Run& run) {
  for (int c = 0; c < count; c += T::kWidth) run(c);
}
// Σ of the numbers times their weights.
UNLATCH_INLINE double combine(const double* numbers, const double* weights, int count) {
  double sum = 0;
  for (int r = 0; r < count; ++r) sum += numbers[r] * weights[r];
  return sum;
}
// to −= scale · numbers
template <class T>
UNLATCH_INLINE void subtract(double* to, int count, double scale, const double* numbers) {
  for_packs<T>(count,
               [&](int c) UNLATCH_INLINE_LAMBDA { store(to + c, load<T>(to + c) - T(scale) * load<T>(numbers + c)); });
}

// Rows of numbers, `stride` apart, of which `count` columns are in use. kStride: the stride if it is known; whole rows
// are whole packs.
template <class T, int kStride = 0>
class Columns {
 public:
  UNLATCH_INLINE Columns(double* rows, std::ptrdiff_t stride, int count)
      : rows_(rows), stride_(stride), count_(count) {}

  UNLATCH_INLINE int get_count() const { return count_; }
  UNLATCH_INLINE std::ptrdiff_t get_stride() const { return kStride > 0 ? kStride : stride_; }
  UNLATCH_INLINE double* row(int r) const { return rows_ + r * get_stride(); }
  UNLATCH_INLINE Columns from(int r) const { return {row(r), stride_, count_}; }
  template <class Run>
  UNLATCH_INLINE void for_packs(const Run& run) const {
    UNLATCH_ISA::for_packs<T>(count_, run);
  }

  UNLATCH_INLINE T get(int r, int c) const { return load<T>(row(r) + c); }
  UNLATCH_INLINE void set(int r, int c, const T& a) const { store(row(r) + c, a); }
  // Six rows, of a pack of columns.
  UNLATCH_INLINE SpatialT<T> get_spatial(int c) const {
    return {{get(0, c), get(1, c), get(2, c)}, {get(3, c), get(4, c), get(5, c)}};
  }
  UNLATCH_INLINE void set_spatial(int c, const SpatialT<T>& a) const {
    set(0, c, a.lin.x);
    set(1, c, a.lin.y);
    set(2, c, a.lin.z);
    set(3, c, a.ang.x);
    set(4, c, a.ang.y);
    set(5, c, a.ang.z);
  }
  // Six rows, of one column.
  UNLATCH_INLINE Spatial get_column(int c) const { return collect<Spatial>(rows_ + c, get_stride()); }
  UNLATCH_INLINE void set_column(int c, const Spatial& a) const { unlatch::spread(rows_ + c, get_stride(), a); }
  // Of six rows: Σ of the columns times their weights.
  UNLATCH_INLINE Spatial combine_columns(const double* weights) const {
    double sums[6];
    for (int i = 0; i < 6; ++i) sums[i] = combine(row(i), weights, count_);
    return collect<Spatial>(sums, 1);
  }

  // Whole rows of zeros. A loop over packs, since g++ makes "rep stos" of a fill, which begins slowly.
  UNLATCH_INLINE void clear(int rows) const {
    static_assert(kStride > 0);
    const T o(0.0);
    for (int i = 0; i < rows * kStride; i += T::kWidth) store(rows_ + i, o);
  }
  // The first rows += Σ x yᵀ of several parts, one after the other in each entry. x: of each part `rows` numbers.
  UNLATCH_INLINE void add_outers(int rows, int parts, const double (*x)[kEight], const double* const* y) const {
    for_packs([&](int c) UNLATCH_INLINE_LAMBDA {
      for (int r = 0; r < rows; ++r) {
        T sum = get(r, c);
        for (int k = 0; k < parts; ++k) sum = sum + T(x[k][r]) * load<T>(y[k] + c);
        set(r, c, sum);
      }
    });
  }

 private:
  double* rows_;
  std::ptrdiff_t stride_;
  int count_;
};

// Of one loop: a block of Λ, or what the loop has at a node (SlotRows).
template <class T>
using LoopColumns = Columns<T, kEight>;

}  // namespace unlatch::UNLATCH_ISA
