#include "kernel/laws/tables.h"

#include <algorithm>

#include "kernel/math/index.h"

namespace unlatch {
namespace {

// Where a coordinate lies on an axis: its cell, and the weights of the knots of that cell's support.
struct AxisPlace {
  double weights[kCellKnots];
  std::int32_t support, stride;
};

// The cell i with knot i ≤ x < knot i + 1: the bucket bounds it, whatever its rounding, and the comparisons decide.
std::int32_t find_cell(const PlanLaws& plan, const PlanTableAxis& axis, double x) {
  const double* knots = &plan.numbers[at(axis.knots)];
  const std::int32_t* buckets = &plan.buckets[at(axis.buckets)];
  const std::int32_t bucket = find_bucket(axis, knots[0], x);
  std::int32_t low = buckets[bucket], high = buckets[bucket + 1] + 1;
  while (high - low > 1) {
    const std::int32_t middle = (low + high) / 2;
    (knots[middle] <= x ? low : high) = middle;
  }
  return low;
}

// Smooth: weights of the support; linear: those of the two knots.
AxisPlace place_smoothly(const PlanLaws& plan, const PlanTableAxis& axis, std::int32_t cell, double u,
                         const double*& values) {
  AxisPlace place{{0, 0, 0, 0}, axis.support, axis.stride};
  const double* c = &plan.numbers[at(axis.cells + cell * kCellNumbers)];
  for (std::int32_t k = 0; k < axis.support; ++k, c += 4) place.weights[k] = c[0] + u * (c[1] + u * (c[2] + u * c[3]));
  const std::int32_t first = std::clamp<std::int32_t>(cell - 1, 0, axis.count - axis.support);
  values += static_cast<std::ptrdiff_t>(first) * axis.stride;
  return place;
}

// Sum over the axes from this one on, the last one, whose values stand side by side, innermost. A linear axis goes from
// the first value to the second.
// `support`: of every smooth axis; 0: each has its own.
template <int axes, bool smooth, int support>
UNLATCH_INLINE double contract(const AxisPlace* axis, const double* values) {
  if constexpr (axes == 0) {
    return *values;
  } else if constexpr (smooth) {
    const std::ptrdiff_t stride = axes == 1 ? 1 : axis->stride, count = support > 0 ? support : axis->support;
    double sum = axis->weights[0] * contract<axes - 1, smooth, support>(axis + 1, values);
    for (std::ptrdiff_t k = 1; k < count; ++k)
      sum += axis->weights[k] * contract<axes - 1, smooth, support>(axis + 1, values + k * stride);
    return sum;
  } else {
    const double a = contract<axes - 1, smooth, support>(axis + 1, values),
                 b = contract<axes - 1, smooth, support>(axis + 1, values + axis->stride);
    return a + (b - a) * axis->weights[0];
  }
}

template <bool smooth, int support>
double contract_all(std::int32_t axes, const AxisPlace* places, const double* values) {
  switch (axes) {
    case 1:
      return contract<1, smooth, support>(places, values);
    case 2:
      return contract<2, smooth, support>(places, values);
    case 3:
      return contract<3, smooth, support>(places, values);
    case 4:
      return contract<4, smooth, support>(places, values);
    case 5:
      return contract<5, smooth, support>(places, values);
    default:
      return contract<6, smooth, support>(places, values);
  }
}

void leave(TableExit& exit, std::int32_t axis, double x, TableAxis::End end) {
  if (exit.axis == kNone) exit = {axis, end, x};
}

}  // namespace

double calc_table(const PlanLaws& plan, const PlanTable& table, const double* at_axis, TableExit& exit) noexcept {
  AxisPlace places[kMostTableAxes];
  const double* values = &plan.numbers[at(table.values)];
  bool full = true;  // every axis has enough knots
  for (std::int32_t i = 0; i < table.axis_count; ++i) {
    const PlanTableAxis& axis = plan.axes[at(table.first_axis + i)];
    const double *knots = &plan.numbers[at(axis.knots)], x = at_axis[i];
    const std::int32_t last = axis.count - 1;
    std::int32_t cell = 0;
    double u = 0;
    if (x >= knots[0] && x < knots[last]) {
      cell = find_cell(plan, axis, x);
      u = (x - knots[cell]) / (knots[cell + 1] - knots[cell]);
    } else if (x >= knots[last]) {
      cell = last - 1;
      u = 1;
      if (x > knots[last]) leave(exit, i, x, axis.above);
    } else if (x < knots[0]) {
      leave(exit, i, x, axis.below);
    } else {
      return x;  // NaN
    }
    if (table.smooth) {
      places[i] = place_smoothly(plan, axis, cell, u, values);
      full = full && axis.support == kCellKnots;
    } else {
      places[i].weights[0] = u;
      places[i].stride = axis.stride;
      values += static_cast<std::ptrdiff_t>(cell) * axis.stride;
    }
  }
  if (!table.smooth) return contract_all<false, 0>(table.axis_count, places, values);
  return full ? contract_all<true, kCellKnots>(table.axis_count, places, values)
              : contract_all<true, 0>(table.axis_count, places, values);
}

}  // namespace unlatch
