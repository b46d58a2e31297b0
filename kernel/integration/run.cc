#include "kernel/integration/run.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "kernel/integration/rigid_rows.h"

namespace unlatch {
namespace {

// False if the masses and arms that the factorisation reads at a node are not finite.
bool has_finite_block(const PlanData& plan, const Evaluation& ev, int node) {
  const TreeNode& n = plan.nodes[at(node)];
  const Place& place = plan.places[at(n.body)];
  const double* blocks = ev.blocks.data();
  const auto is_finite = [](const auto& numbers) {
    double all[sizeof(numbers) / sizeof(double)], sum = 0;
    std::memcpy(all, &numbers, sizeof(numbers));
    for (const double number : all) sum += number;
    return std::isfinite(sum);
  };
  return is_finite(read(blocks, place, &SharedLane::inertia)) &&
         (n.leaf || is_finite(read(blocks, place, &SubtreeLane::A))) &&
         (n.joint == kNone || (is_finite(read(blocks, place, &SolverLane::arm_child)) &&
                               is_finite(read(blocks, place, &SolverLane::offset))));
}

}  // namespace

StepStatus get_pivot_status(const PlanData& plan, const Evaluation& ev, int node) noexcept {
  if (node == kRigidFailure) return StepStatus::kRigidContact;
  return has_finite_block(plan, ev, node) ? StepStatus::kSingular : StepStatus::kNotFinite;
}

void fill_knot(const Run& run, double now, MotionKnot& knot) noexcept {
  const Evaluation& ev = run.ev();
  knot.time = now;
  knot.begins = knot.corner = knot.reading_corner = false;
  std::memcpy(knot.state.get_bytes().data(), run.state().get_bytes().data(), run.state().get_bytes().size());
  for (std::size_t b = 0; b < knot.accelerations.size(); ++b)
    knot.accelerations[b] = ev.get_acceleration(static_cast<int>(b));
  for (std::size_t i = 0; i < knot.multipliers.size(); ++i) knot.multipliers[i] = ev.multipliers[i];
  std::copy(ev.sensors.begin(), ev.sensors.end(), knot.sensors.begin());
  std::copy(ev.quantities.begin(), ev.quantities.end(), knot.quantities.begin());
}

}  // namespace unlatch
