#include "kernel/laws/laws.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "kernel/laws/law_steps.h"
#include "kernel/laws/tables.h"
#include "kernel/quantities/flight.h"
#include "kernel/quantities/quantities.h"

namespace unlatch {
namespace {

double look_up(const Instant& now, std::span<TableExit> exits, std::int32_t number, const double* coordinates) {
  const PlanLaws& plan = now.plan.laws;
  const PlanTable& table = plan.tables[at(number)];
  return rescale(table, now.inputs, calc_table(plan, table, coordinates, exits[at(number)]));
}

}  // namespace

double calc_law(const Instant& now, std::span<const double> operands, std::span<const double> laws,
                const LawTraces& traces, int law) noexcept {
  using Kind = LawStep::Kind;
  const PlanLaws& plan = now.plan.laws;
  const PlanLaw& own = plan.list[at(law)];
  double stack[kLawStack];
  double* top = stack;  // one past the last value
  for (const PlanLawStep& step : std::span(plan.steps).subspan(at(own.first), at(own.count))) switch (step.kind) {
      case Kind::kConstant:
        *top++ = step.value;
        break;
      case Kind::kQuantity:
        *top++ = step.of_law ? laws[at(step.subject)] : operands[at(step.subject)];
        break;
      case Kind::kCommand:
        *top++ = now.inputs.commands[at(step.subject)];
        break;
      case Kind::kTable:
        top -= plan.tables[at(step.subject)].axis_count;
        std::copy_n(top, plan.tables[at(step.subject)].axis_count, &traces.places[at(step.place)]);
        *top = look_up(now, traces.exits, step.subject, top);
        ++top;
        break;
      case Kind::kAdd:
      case Kind::kSubtract:
      case Kind::kMultiply:
      case Kind::kDivide:
      case Kind::kAtan2:
        --top;
        top[-1] = apply(step, top[-1], top[0]);
        break;
      case Kind::kMin:
      case Kind::kMax:
        --top;
        traces.places[at(step.place)] = top[-1] - top[0];
        top[-1] = apply(step, top[-1], top[0]);
        break;
      case Kind::kIfLess:
        top -= 3;
        traces.places[at(step.place)] = top[-1] - top[0];
        if (now.branches == Branches::kDecide) traces.branches[at(step.place)] = top[-1] < top[0] ? 1 : 0;
        if (top[-1] != top[-1] || top[0] != top[0])
          top[-1] += top[0];  // NaN
        else
          top[-1] = traces.branches[at(step.place)] != 0 ? top[1] : top[2];
        break;
      case Kind::kAbs:
        traces.places[at(step.place)] = top[-1];
        top[-1] = apply(step, top[-1]);
        break;
      default:
        top[-1] = apply(step, top[-1]);
    }
  return rescale(own, now.inputs, stack[0]);
}

namespace {

struct Range {
  std::size_t from, to;
};

// Operands, then laws: from and to their places in PlanLaws::operands and PlanLaws::order.
void update_range(const Instant& now, Range operands, Range laws, Evaluation& ev) {
  const PlanLaws& plan = now.plan.laws;
  for (std::size_t i = operands.from; i < operands.to; ++i)
    ev.law_operands[i] = calc_scalar(now, ev, now.plan.quantities[at(plan.operands[i])]);
  for (std::size_t i = laws.from; i < laws.to; ++i)
    ev.laws[at(plan.order[i])] =
        calc_law(now, ev.law_operands, ev.laws, {ev.table_exits, ev.law_places, ev.branches}, plan.order[i]);
}

// The altitudes of bodies whose air laws read, unless `aerodynamics` has them.
void update_air_places(const Instant& now, Evaluation& ev) {
  const PlanData& plan = now.plan;
  for (const PlanAirPlace& own : plan.laws.air_places) {
    const bool acts = own.aerodynamics != kNone &&
                      calc_scale(now.state.elements[at(plan.aerodynamics[at(own.aerodynamics)].element)], now.t) != 0;
    ev.law_places[at(own.place)] = acts ? std::numeric_limits<double>::quiet_NaN()
                                        : quantities::get_flight(now, ev, own.body).place.geodetic.altitude;
  }
}

}  // namespace

std::span<const double> update_driving_laws(const Instant& now, Evaluation& ev) noexcept {
  std::fill(ev.table_exits.begin(), ev.table_exits.end(), TableExit{});
  const PlanLawNumbers& numbers = now.plan.law_numbers;
  update_range(now, {0, at(numbers.driving_operands)}, {0, at(numbers.driving)}, ev);
  update_air_places(now, ev);
  return ev.laws;
}

void update_other_laws(const Instant& now, Evaluation& ev) noexcept {
  const PlanLawNumbers& numbers = now.plan.law_numbers;
  const PlanLaws& plan = now.plan.laws;
  update_range(now, {at(numbers.driving_operands), plan.operands.size()}, {at(numbers.driving), plan.order.size()}, ev);
}

}  // namespace unlatch
