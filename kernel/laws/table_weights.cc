#include "kernel/laws/table_weights.h"

#include <algorithm>
#include <vector>

#include "kernel/math/index.h"

namespace unlatch {
namespace {

constexpr int kDegree = 3;

std::int32_t count_knots(std::span<const double> knots) { return static_cast<std::int32_t>(knots.size()); }

// Knot number i of the B-splines, whose first and last ones count four times.
double get_spline_knot(std::span<const double> knots, std::int32_t i) {
  const std::int32_t n = count_knots(knots), inner = i - kDegree;  // 0: the first of all
  if (inner <= 0) return knots.front();
  return inner >= n - kDegree ? knots.back() : knots[at(inner + 1)];
}

// Values at x of the four B-splines of a piece, by the recurrence of Cox and de Boor.
std::array<double, kCellKnots> calc_splines(std::span<const double> knots, std::int32_t piece, double x) {
  std::array<double, kCellKnots> values{1, 0, 0, 0};
  for (int degree = 1; degree <= kDegree; ++degree) {
    double carried = 0;
    for (int k = 0; k < degree; ++k) {
      const double right = get_spline_knot(knots, piece + kDegree + k + 1);
      const double left = get_spline_knot(knots, piece + kDegree + k + 1 - degree);
      const double part = values[at(k)] / (right - left);
      values[at(k)] = carried + (right - x) * part;
      carried = (x - left) * part;
    }
    values[at(degree)] = carried;
  }
  return values;
}

// Lagrange's polynomials of two or three knots over a cell.
CellWeights calc_parabola(std::span<const double> knots, std::int32_t cell) {
  const double begin = knots[at(cell)], width = knots[at(cell + 1)] - begin;
  CellWeights c{};
  for (std::size_t k = 0; k < knots.size(); ++k) {
    c[k][0] = 1;
    for (std::size_t other = 0; other < knots.size(); ++other) {
      if (other == k) continue;
      const double scale = 1 / (knots[k] - knots[other]), a = (begin - knots[other]) * scale, b = width * scale;
      for (std::size_t power = 3; power > 0; --power) c[k][power] = c[k][power] * a + c[k][power - 1] * b;
      c[k][0] *= a;
    }
  }
  return c;
}

// Rows of the matrix that makes values of coefficients: entry k of row i is of coefficient i + k − kDegree.
constexpr int kBand = 2 * kDegree + 1;
using BandRow = std::array<double, kBand>;

}  // namespace

std::int32_t find_first(std::int32_t knots, std::int32_t cell) {
  return std::clamp(cell - 1, 0, std::max(0, knots - kCellKnots));
}

// The cubics through four points of the cell, at u = 0, 1/3, 2/3 and 1.
CellWeights calc_cell_weights(std::span<const double> knots, std::int32_t cell) {
  if (knots.size() < kCellKnots) return calc_parabola(knots, cell);
  const std::int32_t piece = find_first(count_knots(knots), cell);
  const double begin = knots[at(cell)], end = knots[at(cell + 1)];
  std::array<std::array<double, kCellKnots>, 4> v{};
  for (int i = 0; i < 4; ++i) v[at(i)] = calc_splines(knots, piece, i == 3 ? end : begin + (end - begin) * (i / 3.0));
  CellWeights c{};
  for (std::size_t k = 0; k < kCellKnots; ++k) {
    const double d0 = v[0][k], d1 = v[1][k] - v[0][k], d2 = v[2][k] - 2 * v[1][k] + v[0][k],
                 d3 = v[3][k] - 3 * v[2][k] + 3 * v[1][k] - v[0][k];  // differences; p = d0 + d1 s + …, s = 3 u
    c[k] = {d0, 3 * d1 - 1.5 * d2 + d3, 4.5 * d2 - 4.5 * d3, 4.5 * d3};
  }
  return c;
}

void solve_spline(std::span<const double> knots, std::span<double> numbers, std::int32_t stride) {
  const std::int32_t n = count_knots(knots);
  if (n < kCellKnots) return;
  std::vector<BandRow> rows(at(n), BandRow{});
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t first = find_first(n, std::min(i, n - 2));
    const auto values = calc_splines(knots, first, knots[at(i)]);
    for (std::int32_t k = 0; k < kCellKnots; ++k)
      if (values[at(k)] != 0) rows[at(i)][at(first + k - i + kDegree)] = values[at(k)];
  }
  // Elimination without pivoting: the matrix is totally positive. Entries left of the diagonal keep the factors.
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t r = i + 1; r <= std::min(n - 1, i + kDegree); ++r) {
      double& factor = rows[at(r)][at(i - r + kDegree)];
      if (factor == 0) continue;
      factor /= rows[at(i)][kDegree];
      for (int k = 1; k <= kDegree; ++k) rows[at(r)][at(i - r + kDegree + k)] -= factor * rows[at(i)][at(kDegree + k)];
    }
  const std::size_t whole = at(n) * at(stride);
  for (std::size_t block = 0; block < numbers.size(); block += whole)
    for (std::size_t line = block; line < block + at(stride); ++line) {
      const auto number = [&](std::int32_t i) -> double& { return numbers[line + at(i) * at(stride)]; };
      for (std::int32_t i = 0; i < n; ++i)
        for (std::int32_t k = std::max(0, i - kDegree); k < i; ++k)
          number(i) -= rows[at(i)][at(k - i + kDegree)] * number(k);
      for (std::int32_t i = n - 1; i >= 0; --i) {
        for (std::int32_t k = i + 1; k <= std::min(n - 1, i + kDegree); ++k)
          number(i) -= rows[at(i)][at(k - i + kDegree)] * number(k);
        number(i) /= rows[at(i)][kDegree];
      }
    }
}

}  // namespace unlatch
