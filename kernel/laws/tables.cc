#include "kernel/laws/tables.h"

#include <algorithm>
#include <cstring>

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
template <int axes, bool smooth>
UNLATCH_INLINE double contract(const AxisPlace* axis, const double* values) {
  if constexpr (axes == 0) {
    return *values;
  } else if constexpr (smooth) {
    const std::ptrdiff_t stride = axes == 1 ? 1 : axis->stride, count = axis->support;
    double sum = axis->weights[0] * contract<axes - 1, smooth>(axis + 1, values);
    for (std::ptrdiff_t k = 1; k < count; ++k)
      sum += axis->weights[k] * contract<axes - 1, smooth>(axis + 1, values + k * stride);
    return sum;
  } else {
    const double a = contract<axes - 1, smooth>(axis + 1, values),
                 b = contract<axes - 1, smooth>(axis + 1, values + axis->stride);
    return a + (b - a) * axis->weights[0];
  }
}

// The same of a smooth table whose axes all have the full support: the values along the last axis, side by side, are
// summed as one vector over the other axes, and its weights come last.
struct Row {
  // Two numbers, which an SSE2 or NEON instruction takes at once; elsewhere one after the other, with the same bits.
  typedef double Pair __attribute__((vector_size(16)));
  Pair low, high;
};
static_assert(kCellKnots == 4);
template <int axes>
UNLATCH_INLINE Row contract_rows(const AxisPlace* axis, const double* values) {
  if constexpr (axes == 1) {
    Row row;
    std::memcpy(&row, values, sizeof row);  // values may lie anywhere
    return row;
  } else {
    const std::ptrdiff_t stride = axis->stride;
    Row sum = contract_rows<axes - 1>(axis + 1, values);
    sum = {axis->weights[0] * sum.low, axis->weights[0] * sum.high};
    for (int k = 1; k < kCellKnots; ++k) {
      const Row row = contract_rows<axes - 1>(axis + 1, values + k * stride);
      sum.low += axis->weights[k] * row.low;
      sum.high += axis->weights[k] * row.high;
    }
    return sum;
  }
}
template <int axes>
double contract_full(const AxisPlace* places, const double* values) {
  const Row row = contract_rows<axes>(places, values);
  const double* const w = places[axes - 1].weights;
  return ((w[0] * row.low[0] + w[1] * row.low[1]) + w[2] * row.high[0]) + w[3] * row.high[1];
}
double contract_full(std::int32_t axes, const AxisPlace* places, const double* values) {
  switch (axes) {
    case 1:
      return contract_full<1>(places, values);
    case 2:
      return contract_full<2>(places, values);
    case 3:
      return contract_full<3>(places, values);
    case 4:
      return contract_full<4>(places, values);
    case 5:
      return contract_full<5>(places, values);
    default:
      return contract_full<6>(places, values);
  }
}

template <bool smooth>
double contract_all(std::int32_t axes, const AxisPlace* places, const double* values) {
  switch (axes) {
    case 1:
      return contract<1, smooth>(places, values);
    case 2:
      return contract<2, smooth>(places, values);
    case 3:
      return contract<3, smooth>(places, values);
    case 4:
      return contract<4, smooth>(places, values);
    case 5:
      return contract<5, smooth>(places, values);
    default:
      return contract<6, smooth>(places, values);
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
  if (!table.smooth) return contract_all<false>(table.axis_count, places, values);
  return full ? contract_full(table.axis_count, places, values) : contract_all<true>(table.axis_count, places, values);
}

}  // namespace unlatch
