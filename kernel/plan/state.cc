#include "unlatch/state.h"

#include <algorithm>

#include "kernel/math/hash.h"
#include "kernel/plan/plan_data.h"

namespace unlatch {
namespace {

// Lists of the state in their order, at the beginning of `memory`; without a memory only counts. Returns the bytes.
std::size_t lay_out(const PlanData& plan, std::byte* memory, State& state) noexcept {
  std::size_t used = 0;
  const auto take = [&]<class T>(std::span<T>& list, std::size_t count) {
    if (memory != nullptr) list = {reinterpret_cast<T*>(memory + used), count};
    used += count * sizeof(T);
  };
  std::span<StateHeader> header;
  take(header, 1);
  state.header = header.data();
  take(state.bodies, plan.bodies.size());
  take(state.joints, plan.joints.size());
  take(state.elements, plan.element_scales.size());
  take(state.events, plan.events.size());
  take(state.signals, static_cast<std::size_t>(plan.signal_count));
  take(state.auxiliary, plan.initial_auxiliary.size());
  take(state.contacts, plan.contact_pairs.size());
  take(state.engaged, plan.one_sided.size());
  take(state.bearings, plan.drums.size());
  take(state.rigid_forces, plan.rigid_pairs > 0 ? plan.contact_pairs.size() : 0);
  const std::size_t rough = has_rigid_friction(plan) ? plan.contact_pairs.size() : 0;
  take(state.rigid_slips, rough);
  take(state.rigid_frictions, rough);
  return used;
}

}  // namespace

State::State(const Plan& owner, std::span<std::byte> memory) noexcept {
  bytes_ = memory.first(lay_out(get_data(owner), memory.data(), *this));
}

const PlanOptions& Plan::get_options() const noexcept { return data_->options; }
std::span<const TreeNode> Plan::get_tree() const noexcept { return data_->nodes; }
std::span<const std::int32_t> Plan::get_loops() const noexcept { return data_->loops; }
LoopOverlap Plan::get_loop_overlap() const noexcept {
  LoopOverlap overlap{static_cast<std::int32_t>(data_->loops.size()), 0, !data_->closures.empty()};
  for (const ClusterNode& node : data_->cluster_nodes) overlap.widest = std::max(overlap.widest, node.slots);
  if (!overlap.local) overlap.widest = overlap.loops;
  return overlap;
}
std::size_t Plan::get_sensor_count() const noexcept { return at(data_->sensor_count); }
std::span<const double> Plan::get_initial_commands() const noexcept { return data_->initial_commands; }
std::span<const std::byte> Plan::get_image() const noexcept { return data_->image; }
std::uint64_t Plan::get_hash() const noexcept { return data_->hash; }

std::size_t Plan::get_state_bytes() const noexcept {
  State counted;
  return lay_out(*data_, nullptr, counted);
}

void init_state(const Plan& owner, State& state) noexcept {
  const PlanData& plan = get_data(owner);
  *state.header = {0, plan.hash};
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) state.bodies[b] = plan.bodies[b].initial;
  for (std::size_t j = 0; j < plan.joints.size(); ++j) {
    state.joints[j] = {plan.joints[j].mode, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}};
  }
  for (const PlanCoordinate& c : plan.coordinates)
    if (c.row >= kRotX) state.joints[at(c.joint)].angle[c.row - kRotX] = c.initial;
  for (std::size_t e = 0; e < plan.element_scales.size(); ++e) {
    const double scale = plan.element_scales[e];
    state.elements[e] = {0, scale, scale, 0, 0};
  }
  for (const PlanOneSided& own : plan.one_sided) state.engaged[at(own.number)] = own.engaged;
  for (std::size_t i = 0; i < plan.drums.size(); ++i) state.bearings[i] = plan.drums[i].bearing;
  for (std::size_t e = 0; e < plan.events.size(); ++e) {
    const PlanEvent& event = plan.events[e];
    const bool holds =
        event.crossing || (event.engages != kNone && plan.one_sided[at(event.engages)].engaged == event.engaged);
    state.events[e] = {holds ? EventPhase::kSpent : EventPhase::kArmed, event.timed ? -1.0 : 0.0};
  }
  for (double& signal : state.signals) signal = 0;
  std::copy(plan.initial_auxiliary.begin(), plan.initial_auxiliary.end(), state.auxiliary.begin());
  for (std::size_t i = 0; i < plan.contact_pairs.size(); ++i)
    state.contacts[i] = {plan.contact_pairs[i].closed ? 1 : 0, 0};
  for (double& force : state.rigid_forces) force = 0;
  for (std::span<Vec3> vectors : {state.rigid_slips, state.rigid_frictions})
    for (Vec3& vector : vectors) vector = {0, 0, 0};
}

std::span<const double> get_modal_coordinates(const Plan& owner, const State& state, int body) noexcept {
  for (const PlanFlexible& flexible : get_data(owner).flexible)
    if (flexible.body == body) return state.auxiliary.subspan(at(flexible.auxiliary), at(flexible.modes));
  return {};
}

std::uint64_t calc_hash(const State& state) noexcept { return calc_words_hash(state.get_bytes()); }

}  // namespace unlatch
