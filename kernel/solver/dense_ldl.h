// LDLᵀ of small dense symmetric matrices: modal coordinates of a flexible body, its whole block, the rows of loops.
// Only the lower triangle is read and written; a factor has its pivots on the diagonal and the unit lower triangle
// below it.
#pragma once

#include <cstddef>
#include <utility>

#include "kernel/math/lower_triangle.h"

namespace unlatch {

// A pivot this small beside its diagonal entry is rounding.
inline constexpr double kSingularPivot = 1e-13;

// Factors an n × n matrix in place, row by row: first L D of the row, then L and the pivot. False if a pivot vanishes.
inline bool factor_ldl(const LowerTriangle& A, int n) {
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < r; ++c)
      for (int k = 0; k < c; ++k) A(r, c) -= A(r, k) * A(c, k);
    double pivot = A(r, r);
    for (int c = 0; c < r; ++c) {
      const double scaled = A(r, c);
      A(r, c) = scaled / A(c, c);
      pivot -= scaled * A(r, c);
    }
    if (!(pivot > kSingularPivot * A(r, r))) return false;
    A(r, r) = pivot;
  }
  return true;
}

// a / s, number by number.
inline double divide(double a, double s) { return a / s; }
inline Spatial divide(const Spatial& a, double s) {
  return {{a.lin.x / s, a.lin.y / s, a.lin.z / s}, {a.ang.x / s, a.ang.y / s, a.ang.z / s}};
}

// Solves in place. X: double, or Spatial for six right-hand sides at once.
template <class X>
inline void solve_ldl(const LowerTriangle& A, int n, X* x) {
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < r; ++c) x[r] = x[r] - A(r, c) * x[c];
  for (int r = n - 1; r >= 0; --r) {
    x[r] = divide(x[r], A(r, r));
    for (int k = r + 1; k < n; ++k) x[r] = x[r] - A(k, r) * x[k];
  }
}

// Symmetric interchange of what is left at r with what is left at s ≤ r, in an n × n matrix.
inline void interchange(const LowerTriangle& A, int n, int s, int r) {
  if (r == s) return;
  std::swap(A(s, s), A(r, r));
  for (int k = 0; k < s; ++k) std::swap(A(s, k), A(r, k));
  for (int k = s + 1; k < r; ++k) std::swap(A(k, s), A(r, k));
  for (int k = r + 1; k < n; ++k) std::swap(A(k, s), A(k, r));
}

}  // namespace unlatch
