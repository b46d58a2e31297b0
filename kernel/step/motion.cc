#include "unlatch/motion.h"

#include <algorithm>
#include <new>

#include "kernel/events/corners.h"
#include "kernel/plan/plan_data.h"
#include "unlatch/model/contact_substeps.h"

namespace unlatch {
namespace {

// Number of knots: beginning and end of the step, and two for each instant between; these are its splits at events and
// at corners, its beginning, and the ends of the parts into which closed contacts cut it.
std::size_t count_knots(const PlanData& plan) {
  const std::size_t parts = plan.contacts.empty()                        ? 1
                            : has_automatic_parts(plan.contact_substeps) ? at(kMaxAutomaticSubsteps)
                                                                         : at(plan.contact_substeps);
  return 2 * (at(plan.options.max_splits) + at(kMostCornerSplits) + parts) + 2;
}

std::size_t count_numbers(const Plan& owner) {
  const PlanData& plan = get_data(owner);
  return plan.bodies.size() * (sizeof(Spatial) / sizeof(double)) + plan.joints.size() * kRows +
         owner.get_sensor_count() + at(plan.quantity_count);
}

}  // namespace

std::size_t MotionLog::get_bytes(const Plan& plan) noexcept {
  const std::size_t each = plan.get_state_bytes() + count_numbers(plan) * sizeof(double);
  return count_knots(get_data(plan)) * (sizeof(MotionKnot) + each) + kMostRounds * (sizeof(RoundKnot) + each);
}

MotionLog::MotionLog(const Plan& plan, std::span<std::byte> memory) noexcept : capacity_(count_knots(get_data(plan))) {
  std::byte* cursor = memory.data();
  knots_ = reinterpret_cast<MotionKnot*>(cursor);
  cursor += capacity_ * sizeof(MotionKnot);
  rounds_ = reinterpret_cast<RoundKnot*>(cursor);
  cursor += kMostRounds * sizeof(RoundKnot);
  const std::size_t bodies = get_data(plan).bodies.size(), rows = get_data(plan).joints.size() * kRows;
  const auto place = [&](MotionKnot& knot) {
    knot.state = State(plan, {cursor, plan.get_state_bytes()});
    cursor += plan.get_state_bytes();
    knot.accelerations = {reinterpret_cast<Spatial*>(cursor), bodies};
    cursor += bodies * sizeof(Spatial);
    knot.multipliers = {reinterpret_cast<double*>(cursor), rows};
    cursor += rows * sizeof(double);
    knot.sensors = {reinterpret_cast<double*>(cursor), plan.get_sensor_count()};
    cursor += plan.get_sensor_count() * sizeof(double);
    knot.quantities = {reinterpret_cast<double*>(cursor), at(get_data(plan).quantity_count)};
    cursor += knot.quantities.size() * sizeof(double);
  };
  for (std::size_t i = 0; i < capacity_; ++i) place(*new (knots_ + i) MotionKnot);
  for (std::size_t i = 0; i < kMostRounds; ++i) place((new (rounds_ + i) RoundKnot)->knot);
}

MotionKnot& MotionLog::add() noexcept {
  count_ = std::min(count_ + 1, capacity_);
  return knots_[count_ - 1];
}

RoundKnot* MotionLog::add_round() noexcept { return round_count_ < kMostRounds ? rounds_ + round_count_++ : nullptr; }

RoundKnot* MotionLog::get_last_round() noexcept { return round_count_ > 0 ? rounds_ + (round_count_ - 1) : nullptr; }

}  // namespace unlatch
