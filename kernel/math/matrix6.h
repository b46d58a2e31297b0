// Symmetric 6×6 matrices over spatial vectors, entry by entry: the block of a flexible body. Rows and columns are those
// of (lin, ang), world axes.
#pragma once

#include <array>
#include <bit>
#include <utility>

#include "kernel/math/lower_triangle.h"

namespace unlatch {

using SixNumbers = std::array<double, 6>;
inline SixNumbers to_numbers(const Spatial& a) { return std::bit_cast<SixNumbers>(a); }
inline Spatial to_spatial(const SixNumbers& a) { return std::bit_cast<Spatial>(a); }

struct Matrix6 {
  std::array<SixNumbers, 6> rows;

  LowerTriangle get_lower() { return {rows.front().data(), 6}; }
};

inline Spatial operator*(const Matrix6& A, const Spatial& x) {
  SixNumbers out;
  for (std::size_t i = 0; i < 6; ++i) out[i] = dot(to_spatial(A.rows[i]), x);
  return to_spatial(out);
}
inline Matrix6& operator+=(Matrix6& A, const Matrix6& B) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 6; ++k) A.rows[i][k] += B.rows[i][k];
  return A;
}

// Xᵀ A X: A, given at a point `r` away from the origin, as seen there. Moves the columns as wrenches, then the rows.
inline Matrix6 shift(Matrix6 A, const Vec3& r) {
  const auto shift_rows = [&] {
    for (SixNumbers& row : A.rows) row = to_numbers(shift_wrench(to_spatial(row), r));
  };
  shift_rows();
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = i + 1; k < 6; ++k) std::swap(A.rows[i][k], A.rows[k][i]);
  shift_rows();
  return A;
}

// An articulated block as a matrix: (M H; Hᵀ I).
inline Matrix6 to_matrix(const Articulated& block) {
  Matrix6 A;
  const auto set = [&](std::size_t row, std::size_t column, double entry) {
    A.rows[row][column] = A.rows[column][row] = entry;
  };
  const auto set_symmetric = [&](std::size_t first, const Sym3& s) {
    const double rows[3][3] = {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = i; k < 3; ++k) set(first + i, first + k, rows[i][k]);
  };
  const auto set_coupling = [&](std::size_t k, const Vec3& column) {
    set(0, 3 + k, column.x);
    set(1, 3 + k, column.y);
    set(2, 3 + k, column.z);
  };
  set_symmetric(0, block.M);
  set_symmetric(3, block.I);
  set_coupling(0, block.H.x);
  set_coupling(1, block.H.y);
  set_coupling(2, block.H.z);
  return A;
}
// The block of a matrix, from its upper triangle.
inline Articulated to_block(const Matrix6& A) {
  const auto get = [&](std::size_t row, std::size_t column) { return A.rows[row][column]; };
  const auto get_symmetric = [&](std::size_t i) -> Sym3 {
    return {get(i, i), get(i + 1, i + 1), get(i + 2, i + 2), get(i, i + 1), get(i, i + 2), get(i + 1, i + 2)};
  };
  const auto get_coupling = [&](std::size_t k) -> Vec3 { return {get(0, 3 + k), get(1, 3 + k), get(2, 3 + k)}; };
  return {get_symmetric(0), {get_coupling(0), get_coupling(1), get_coupling(2)}, get_symmetric(3)};
}

}  // namespace unlatch
