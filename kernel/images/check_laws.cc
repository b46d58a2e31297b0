// Tables and expressions: each value that a law takes is there, and its stack holds what it keeps.
#include "kernel/images/plan_check.h"
#include "kernel/laws/law_steps.h"

namespace unlatch {

void PlanCheck::check_tables() {
  const PlanLaws& laws = plan_.laws;
  for (const PlanTableAxis& axis : laws.axes) {
    require(axis.count >= 2 && axis.count <= static_cast<std::int32_t>(kMostTableKnots));
    require(axis.support >= 2 && axis.support <= kCellKnots && axis.support <= axis.count && axis.stride >= 1);
    require_kind(axis.below, TableAxis::End::kError);
    require_kind(axis.above, TableAxis::End::kError);
    require_range(axis.knots, axis.count, laws.numbers.size());
    require(axis.bucket_count >= 1);
    require_range(axis.buckets, std::int64_t{axis.bucket_count} + 1, laws.buckets.size());
    if (!good_) return;
    for (std::int32_t b = 0; b <= axis.bucket_count; ++b)
      require_index(laws.buckets[at(axis.buckets + b)], at(b < axis.bucket_count ? axis.count - 1 : axis.count));
  }
  for (const PlanTable& table : laws.tables) {
    require_flag(table.smooth);
    require_channel(table.scale_channel);
    require_channel(table.offset_channel);
    require(table.axis_count >= 1 && table.axis_count <= static_cast<std::int32_t>(kMostTableAxes));
    require_range(table.first_axis, table.axis_count, laws.axes.size());
    if (!good_) return;
    std::int64_t last = table.values;
    for (std::int32_t a = 0; a < table.axis_count; ++a) {
      const PlanTableAxis& axis = laws.axes[at(table.first_axis + a)];
      last += std::int64_t{axis.count - 1} * axis.stride;
      if (table.smooth) require_range(axis.cells, std::int64_t{axis.count - 1} * kCellNumbers, laws.numbers.size());
      require(a + 1 < table.axis_count || axis.stride == 1);
    }
    require(table.values >= 0);
    require_index(last, laws.numbers.size());
  }
}

void PlanCheck::check_laws() {
  const PlanLaws& laws = plan_.laws;
  require_range(0, plan_.law_numbers.driving, laws.order.size());
  require_range(0, plan_.law_numbers.driving_operands, laws.operands.size());
  for (const std::int32_t law : laws.order) require_index(law, laws.list.size());
  for (const std::int32_t quantity : laws.operands) require_index(quantity, plan_.quantities.size());
  for (const PlanCorner& corner : laws.corners) {
    require_flag(corner.jumps);
    require_index(corner.place, at(plan_.law_numbers.places));
    require_range(corner.knots, corner.count, laws.numbers.size());
    require(corner.count >= 1);
  }
  for (const PlanAirPlace& own : laws.air_places) {
    require(plan_.environment.has_air);
    require_index(own.place, at(plan_.law_numbers.places));
    require_body(own.body);
    require_optional(own.aerodynamics, plan_.aerodynamics.size());
    require_range(own.knots, own.count, laws.numbers.size());
  }
  for (const PlanLawStep& step : laws.steps) {
    require_kind(step.kind, LawStep::Kind::kIfLess);
    require_flag(step.of_law);
  }
  if (!good_) return;
  for (const PlanLaw& law : laws.list) check_law(law);
}

// Walks through the steps as calc_law() does.
void PlanCheck::check_law(const PlanLaw& law) {
  using Kind = LawStep::Kind;
  constexpr std::int32_t kMostPower = 8;
  const PlanLaws& laws = plan_.laws;
  require_channel(law.scale_channel);
  require_channel(law.offset_channel);
  require_range(law.first, law.count, laws.steps.size());
  if (!good_) return;
  std::int32_t depth = 0;
  for (std::int32_t i = law.first; i < law.first + law.count && good_; ++i) {
    const PlanLawStep& step = laws.steps[at(i)];
    const LawOperands& operands = get_operands(step.kind);
    std::int32_t takes = operands.takes, places = operands.decides ? 1 : 0;
    switch (step.kind) {
      case Kind::kQuantity:
        require_index(step.subject, step.of_law ? laws.list.size() : laws.operands.size());
        break;
      case Kind::kCommand:
        require_index(step.subject, plan_.initial_commands.size());
        break;
      case Kind::kTable:
        require_index(step.subject, laws.tables.size());
        if (good_) takes = places = laws.tables[at(step.subject)].axis_count;
        break;
      case Kind::kPower:
        require(step.subject >= -kMostPower && step.subject <= kMostPower);
        break;
      default:
        break;
    }
    require(depth >= takes);
    depth += 1 - takes;
    require(depth <= kLawStack);
    if (places > 0) require_range(step.place, places, at(plan_.law_numbers.places));
  }
  require(depth == 1);
}

}  // namespace unlatch
