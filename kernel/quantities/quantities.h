// Values of the plan's quantities: one number for guards and for the model's quantities, several for sensors.
#pragma once

#include "kernel/quantities/quantity_calc.h"

namespace unlatch {

// All values of a kind; returns how many. `out`: kMostValues numbers.
int calc_values(const Instant& now, const Evaluation& ev, const PlanQuantity& own, double* out) noexcept;
// The one number that `part` or the direction chooses.
double calc_scalar(const Instant& now, const Evaluation& ev, const PlanQuantity& own) noexcept;

// ev.quantities and ev.sensors, from all the rest of the evaluation of this instant. `unread`: null, or per sensor, not
// 0: it stays as it is.
void update_readings(const Instant& now, Evaluation& ev, const std::uint8_t* unread = nullptr) noexcept;
// A command changes one of them by itself, without a change of the evaluation.
bool is_any_reading_commanded(const PlanData& plan) noexcept;

}  // namespace unlatch
