#include "kernel/compile/quantities.h"

#include "kernel/model/from_eigen.h"

namespace unlatch {

std::int32_t add_quantity(const Quantity& quantity, PlanDraft& plan) {
  PlanQuantity out{.kind = quantity.kind, .subject = quantity.subject, .other = quantity.other, .part = quantity.part};
  out.direction = to_vec(quantity.direction);
  out.other_direction = to_vec(quantity.other_direction);
  out.point = to_vec(quantity.point);
  out.along = !quantity.direction.isZero(0) && !get_traits(quantity.kind).has_axes;
  plan.quantities.push_back(out);
  return static_cast<std::int32_t>(plan.quantities.size()) - 1;
}

DraftWithQuantities compile_quantities(const Model& model, PlanDraft& plan) {
  for (const Quantity& quantity : model.quantities) add_quantity(quantity, plan);
  plan.quantity_count = static_cast<std::int32_t>(plan.quantities.size());
  return {plan};
}

}  // namespace unlatch
