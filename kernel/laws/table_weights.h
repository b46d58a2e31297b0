// Weights by which smooth tables are interpolated along one axis, and the numbers that they weigh: the cubic B-splines
// over all knots but the second and the last but one (de Boor, A Practical Guide to Splines, 1978, chapters IX and
// XIII), so that the two outer cells on each side share a cubic, and their coefficients. Three knots have a parabola,
// two a line. Each cell takes in as many numbers as there are, at most kCellKnots, from find_first() on.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "kernel/plan/plan_laws.h"

namespace unlatch {

// Per number of the cell's support the coefficients of 1, u, u², u³, u from 0 to 1 over the cell.
using CellWeights = std::array<std::array<double, 4>, kCellKnots>;

// The first number of a cell's support.
std::int32_t find_first(std::int32_t knots, std::int32_t cell);

CellWeights calc_cell_weights(std::span<const double> knots, std::int32_t cell);

// Values along one axis become the numbers that the weights are of; `stride`: from one to the next along the axis.
void solve_spline(std::span<const double> knots, std::span<double> numbers, std::int32_t stride);

}  // namespace unlatch
