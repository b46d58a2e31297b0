#include "kernel/plan/evaluation.h"

#include <algorithm>
#include <limits>
#include <new>

namespace unlatch {
namespace {

constexpr std::size_t kAlignment = 64;

// Divides one memory into parts; without a memory it only counts the bytes that they need.
class Arena {
 public:
  explicit Arena(std::byte* memory) : memory_(memory) {}

  template <class T>
  void take(std::span<T>& out, std::size_t count) {
    if (memory_ != nullptr) out = {reinterpret_cast<T*>(memory_ + used_), count};
    used_ += (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
  }
  std::size_t get_used() const { return used_; }

 private:
  std::byte* memory_;
  std::size_t used_ = 0;
};

// The unknowns are as many as the redundant rows or as the others, whichever are fewer.
void lay_out_split(const PlanData& plan, Arena& arena, SplitScratch& split) {
  if (!plan.closures.empty()) return;
  const auto loop_rows = static_cast<std::size_t>(plan.loop_rows);
  const std::size_t rows = loop_rows + static_cast<std::size_t>(plan.ring_rows);
  const std::size_t unknowns = std::min(loop_rows, rows / 2);
  arena.take(split.relation, loop_rows * rows);
  arena.take(split.matrix, unknowns * unknowns);
  arena.take(split.scales, rows);
  arena.take(split.loads, rows);
  arena.take(split.unknowns, unknowns);
  arena.take(split.shares, loop_rows);
  arena.take(split.ring_columns, plan.ring_joints.size());
}

void lay_out_rigid(const PlanData& plan, Arena& arena, Evaluation& ev) {
  const std::size_t n = static_cast<std::size_t>(count_rigid_rows(plan)), any = n > 0 ? 1 : 0;
  arena.take(ev.pair_forces, any * plan.contact_pairs.size());
  const std::size_t rough = has_rigid_friction(plan) ? plan.contact_pairs.size() : 0;
  arena.take(ev.pair_frictions, rough);
  arena.take(ev.pair_slides, rough);
  RigidScratch& rigid = ev.rigid;
  arena.take(rigid.rows, n);
  for (std::span<double>* matrix : {&rigid.matrix, &rigid.factor, &rigid.gram}) arena.take(*matrix, n * n);
  for (std::span<double>* numbers : {&rigid.loads, &rigid.forces, &rigid.middle, &rigid.pivots})
    arena.take(*numbers, n);
  for (std::span<double>* numbers : {&rigid.trial, &rigid.residual}) arena.take(*numbers, rough > 0 ? n : 0);
  arena.take(rigid.independent, n);
  arena.take(rigid.body_forces, any * plan.bodies.size());
}

void lay_out(const PlanData& plan, Arena& arena, Evaluation& ev) {
  arena.take(ev.blocks, static_cast<std::size_t>(plan.block_numbers));
  arena.take(ev.modes, plan.groups.size());
  Auxiliary& x = ev.auxiliary;
  for (std::span<double>* numbers : {&x.now, &x.rate, &x.start, &x.first, &x.sum})
    arena.take(*numbers, plan.initial_auxiliary.size());
  arena.take(ev.profiles, plan.profiles.size());
  arena.take(ev.load_sizes, plan.loads.size());
  arena.take(ev.laws, plan.laws.list.size());
  arena.take(ev.law_operands, plan.laws.operands.size());
  arena.take(ev.law_places, static_cast<std::size_t>(plan.law_numbers.places));
  for (std::span<std::int32_t>* branches : {&ev.branches, &ev.branches_at_start})
    arena.take(*branches, static_cast<std::size_t>(plan.law_numbers.places));
  arena.take(ev.middle_places, plan.laws.corners.empty() ? 0 : static_cast<std::size_t>(plan.law_numbers.places));
  arena.take(ev.table_exits, plan.laws.tables.size());
  for (std::span<double>* altitudes : {&ev.altitudes, &ev.middle_altitudes})
    arena.take(*altitudes, plan.air_corners.empty() ? 0 : plan.aerodynamics.size());
  for (std::span<double>* travels : {&ev.travels, &ev.middle_travels})
    arena.take(*travels, plan.travels.empty() ? 0 : plan.one_sided.size());
  arena.take(ev.friction_sizes, plan.frictions.size());
  arena.take(ev.varying, plan.varying.size());
  arena.take(ev.modal, static_cast<std::size_t>(plan.modal_work));
  arena.take(ev.compliant, plan.compliant.size());
  arena.take(ev.coordinates, plan.coordinates.size());
  arena.take(ev.speeds, plan.coordinates.size());
  for (std::span<double>* rotations : {&ev.rotation_sines, &ev.rotation_cosines})
    arena.take(*rotations, static_cast<std::size_t>(plan.rotation_count + 7) / 8 * 8);  // whole packs
  arena.take(ev.non_tree_frames, plan.non_tree_joints.size());
  arena.take(ev.non_tree_bias, plan.non_tree_joints.size());
  const auto loop_rows = static_cast<std::size_t>(plan.loop_rows),
             columns = static_cast<std::size_t>(plan.loop_columns);
  const bool dense = plan.closures.empty();
  arena.take(ev.loop_rows, dense ? loop_rows : 0);
  arena.take(ev.loop_ranges, !dense || plan.loops.empty() ? 0 : plan.loops.size() + 1);
  arena.take(ev.loop_matrix, dense ? loop_rows * columns : 0);
  arena.take(ev.loop_loads, dense ? static_cast<std::size_t>(plan.loop_load_rows) * columns : 0);
  arena.take(ev.loop_replies, dense ? kLoopReplies * columns : 0);
  arena.take(ev.loop_column, dense ? columns : 0);
  arena.take(ev.loop_forces, !dense || plan.loops.empty() ? 0 : plan.bodies.size());
  arena.take(ev.closures, plan.closures.size());
  for (std::span<double>* matrix : {&ev.cluster_matrix, &ev.split_matrix})
    arena.take(*matrix, static_cast<std::size_t>(plan.cluster_blocks) * kBlockNumbers);
  arena.take(ev.cluster_columns, static_cast<std::size_t>(plan.cluster_numbers));
  arena.take(ev.split_columns, plan.loop_slots.size() * kBlockNumbers);
  arena.take(ev.loop_solution, dense ? loop_rows : 0);
  lay_out_split(plan, arena, ev.split);
  for (std::span<double>* pairs : {&ev.pair_distances, &ev.pair_rates}) arena.take(*pairs, plan.contact_pairs.size());
  arena.take(ev.closed_pairs, plan.contact_pairs.size());
  arena.take(ev.pair_features, plan.contact_pairs.size());
  lay_out_rigid(plan, arena, ev);
  arena.take(ev.guards, plan.events.size() + plan.contact_pairs.size());
  arena.take(ev.sensors, static_cast<std::size_t>(plan.sensor_count));
  arena.take(ev.quantities, static_cast<std::size_t>(plan.quantity_count));
}

void lay_out(const PlanData& plan, Arena& arena, WorkspaceData& data) {
  lay_out(plan, arena, data.kept.evaluation);
  arena.take(data.kept.commands, at(plan.channel_count));
  EventSearch& search = data.search;
  const std::size_t events = plan.events.size();
  for (std::span<double>* guards :
       {&search.guards_low, &search.guards_high, &search.guards_middle, &search.tolerances, &data.exact})
    arena.take(*guards, events + plan.contact_pairs.size());
  for (std::span<double>* rates : {&search.rates_low, &search.rates_high})
    arena.take(*rates, plan.contact_pairs.size());
  arena.take(search.features_low, plan.contact_pairs.size());
  arena.take(search.places_low, static_cast<std::size_t>(plan.law_numbers.places));
  arena.take(search.altitudes_low, plan.air_corners.empty() ? 0 : plan.aerodynamics.size());
  arena.take(search.travels_low, plan.travels.empty() ? 0 : plan.one_sided.size());
  arena.take(search.acting, events);
  arena.take(search.stack, static_cast<std::size_t>(plan.guard_depth));
  const std::size_t rigid = plan.rigid_pairs > 0 ? plan.contact_pairs.size() : 0;
  arena.take(search.rigid, rigid);
  arena.take(search.rigid_returns, rigid);
  arena.take(search.rigid_lifts, rigid);
  // An event acts at most once at an instant; a step has at most its splits and its beginning and end as instants.
  const std::size_t instants = static_cast<std::size_t>(plan.options.max_splits) + 2;
  arena.take(data.events.fired, events * instants);
  arena.take(data.events.audits, (events + plan.contact_pairs.size()) * instants);
  arena.take(data.unread, plan.sensors.size());
}

}  // namespace

Workspace::Workspace(const Plan& owner, std::span<std::byte> memory) noexcept {
  const PlanData& plan = get_data(owner);
  Arena arena(memory.data());
  std::span<WorkspaceData> data;
  std::span<std::byte> state;
  arena.take(data, 1);
  data_ = new (data.data()) WorkspaceData;
  Evaluation& ev = data_->kept.evaluation;
  lay_out(plan, arena, *data_);
  arena.take(state, owner.get_state_bytes());
  data_->kept.state = State(owner, state);

  for (KeptProfile& profile : ev.profiles) profile.s = std::numeric_limits<double>::quiet_NaN();
  for (double& size : ev.friction_sizes) size = 0;
  for (TableExit& exit : ev.table_exits) exit = {};
  for (const std::span<std::int32_t> branches : {ev.branches, ev.branches_at_start})
    for (std::int32_t& branch : branches) branch = 0;
  for (const std::span<double> places :
       {ev.law_places, ev.middle_places, ev.altitudes, ev.middle_altitudes, ev.travels, ev.middle_travels})
    for (double& place : places) place = 0;
  for (double& tolerance : data_->exact) tolerance = 0;
  for (std::uint8_t& unread : data_->unread) unread = 0;
  ev.places = plan.places;
  ev.multipliers = multipliers = {ev.blocks.data(), plan.multipliers};
  for (const PlanNonTreeJoint& joint : plan.non_tree_joints)  // no solve writes those of a joint that never holds
    for (std::size_t r = 0; r < kRows; ++r) multipliers.get(at(joint.joint), r) = 0;
  accelerations = {ev.blocks.data(), plan.accelerations};
  sensors = ev.sensors;
  quantities = ev.quantities;
  laws = ev.laws;
  table_exits = ev.table_exits;
}

void Workspace::leave_unread(const Plan& owner, std::span<const int> unread) noexcept {
  const std::span<const PlanSensor> all = get_data(owner).sensors;
  Evaluation& ev = data_->kept.evaluation;
  for (const int sensor : unread) {
    const std::size_t i = at(sensor);
    data_->unread[i] = 1;
    const std::size_t end = i + 1 < all.size() ? at(all[i + 1].first) : ev.sensors.size();
    for (std::size_t k = at(all[i].first); k < end; ++k) ev.sensors[k] = 0;
  }
}

std::size_t Plan::get_workspace_bytes() const noexcept {
  Arena arena(nullptr);
  WorkspaceData scratch;
  std::span<WorkspaceData> data;
  std::span<std::byte> state;
  arena.take(data, 1);
  lay_out(*data_, arena, scratch);
  arena.take(state, get_state_bytes());
  return arena.get_used();
}

}  // namespace unlatch
