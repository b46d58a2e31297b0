#include "unlatch/readings.h"

#include "kernel/elements/element_reading.h"
#include "kernel/elements/kinds/kinds.h"

namespace unlatch {
SpringReading calc_point_spring(const Plan& plan, const State& state, int spring) noexcept {
  const PlanPointSpring& own = get_data(plan).point_springs[at(spring)];
  const double scale = calc_scale(state.elements[at(own.element)], get_data(plan).get_time(state.header->tick));
  const PointSpringForce f =
      PointSpringKind::calc_force(own, calc_body_frame(state, own.base), calc_body_frame(state, own.follower), scale);
  return {f.length, scale == 0 ? 0 : f.size, scale};
}

namespace {

template <class Motion>
ElementReading read_element(const Motion& motion, int element) noexcept {
  const double scale = calc_scale(motion.state().elements[at(element)], motion.time());
  ElementReading out{.scale = scale};
  for_each_kind([&]<class Kind>(Kind) {
    // Elements of one kind have consecutive numbers.
    const auto& list = Kind::of_plan(motion.plan());
    const std::size_t i = list.empty() ? 0 : at(element) - at(list[0].element);
    if (i >= list.size()) return;
    if constexpr (HasEffort<Kind>) {
      const Effort effort = Kind::calc(motion, list[i], i, scale);
      out = {effort.size, effort.length, effort.rate, scale, effort.stroke, effort.wound, effort.on_drum};
    } else {
      out = Kind::read(motion, list[i], i, scale);
    }
  });
  return out;
}

}  // namespace

ElementReading calc_element(const Instant& now, const Evaluation& ev, int element) noexcept {
  return read_element(StageMotion{now, ev}, element);
}

ElementReading calc_element(const Plan& plan, const Workspace& workspace, int element) noexcept {
  return read_element(FinalMotion{get_data(plan), get_data(workspace).kept}, element);
}

std::span<const double> get_modal_rates(const Plan& plan, const State& state, int body) noexcept {
  const std::span<const double> own = get_modal_coordinates(plan, state, body);
  return own.empty() ? own : std::span<const double>(own.data() + own.size(), own.size());
}

}  // namespace unlatch
