// What tools/cost has measured on a target: the instructions of each unit of work in each primitive.
#pragma once

#include <span>

#include "kernel/cost/primitives.h"
#include "kernel/cost/work.h"
#include "unlatch/cost/step_cost.h"

namespace unlatch::cost {

struct Coefficient {
  Primitive primitive;
  Unit unit;
  double instructions;
};

struct Measured {
  CostTarget target;
  std::span<const Unit> units;  // that some measured plan has
  std::span<const Coefficient> coefficients;
};

// All targets; measured/*.cc, which tools/cost writes.
std::span<const Measured* const> list_measured() noexcept;

}  // namespace unlatch::cost
