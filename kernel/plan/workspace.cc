#include "kernel/plan/workspace.h"

#include <algorithm>

#include "kernel/plan/lane_access.h"
#include "kernel/plan/loop_nodes.h"
#include "unlatch/plan.h"
#include "unlatch/step.h"

namespace unlatch {
namespace {

constexpr std::size_t kAlignment = 64;

// Hands out parts of one block, or, without a block, only counts what they need.
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

std::size_t lay_out(const Plan& plan, std::byte* memory, Workspace& ws) {
  Arena arena(memory);
  const std::size_t events = plan.events.size();
  arena.take(ws.lanes, static_cast<std::size_t>(plan.lane_numbers));
  arena.take(ws.phases, plan.groups.size());
  Extras& e = ws.extras;
  for (std::span<double>* extras : {&e.now, &e.rate, &e.start, &e.first, &e.sum})
    arena.take(*extras, plan.initial_extras.size());
  arena.take(ws.profiles, plan.profiles.size());
  arena.take(ws.load_sizes, plan.loads.size());
  arena.take(ws.varying, plan.varying.size());
  arena.take(ws.modal, static_cast<std::size_t>(plan.modal_work));
  arena.take(ws.compliant, plan.compliant.size());
  arena.take(ws.coordinates, plan.coordinates.size());
  arena.take(ws.speeds, plan.coordinates.size());
  for (std::span<double>* turns : {&ws.turn_sines, &ws.turn_cosines})
    arena.take(*turns, static_cast<std::size_t>(plan.turn_count + 7) / 8 * 8);  // whole packs
  arena.take(ws.loose_frames, plan.loose_joints.size());
  arena.take(ws.loose_bias, plan.loose_joints.size());
  const auto loop_rows = static_cast<std::size_t>(plan.loop_rows),
             columns = static_cast<std::size_t>(plan.loop_columns);
  arena.take(ws.loop_rows, loop_rows);
  arena.take(ws.loop_ranges, plan.loops.empty() ? 0 : plan.loops.size() + 1);
  arena.take(ws.loop_matrix, loop_rows * columns);
  arena.take(ws.loop_loads, (static_cast<std::size_t>(plan.loop_load_rows) + kLoopScratch) * columns);
  arena.take(ws.loop_solution, loop_rows);
  std::span<std::byte> accepted;
  arena.take(accepted, plan.get_state_bytes());
  if (memory != nullptr) ws.accepted = State(plan, accepted);
  for (std::span<double>* guards : {&ws.guards, &ws.guards_low, &ws.guards_high, &ws.guards_middle, &ws.tolerances})
    arena.take(*guards, events);
  arena.take(ws.acting, events);
  arena.take(ws.stack, static_cast<std::size_t>(plan.guard_depth));
  // An event acts at most once at an instant; a step has at most its splits and its beginning and end as instants.
  const std::size_t instants = static_cast<std::size_t>(plan.options.max_splits) + 2;
  arena.take(ws.fired, events * instants);
  arena.take(ws.audits, events * instants);
  arena.take(ws.sensors, static_cast<std::size_t>(plan.sensor_count));
  return arena.get_used();
}

}  // namespace

Workspace::Workspace(const Plan& plan, std::span<std::byte> memory) noexcept {
  lay_out(plan, memory.data(), *this);
  slots = plan.body_slots;
  kinematics = {lanes.data(), slots};
  accelerations = {lanes.data(), slots};
  multipliers = {lanes.data(), plan.multipliers};
  for (const PlanLooseJoint& loose : plan.loose_joints)  // of one that never holds nobody else writes them
    for (std::size_t r = 0; r < kRows; ++r) multipliers.get(static_cast<std::size_t>(loose.joint), r) = 0;
}

Spatial read_acceleration(const double* lanes, LaneSlot slot) noexcept {
  return read_spatial(lanes, slot, kAcceleration);
}

BodyKinematics read_kinematics(const double* lanes, LaneSlot slot) noexcept {
  const Vec3 moments = read_vec(lanes, slot, kInertia), products = read_vec(lanes, slot, kInertia + 3);
  return {read_mat(lanes, slot, kRotation),
          read_vec(lanes, slot, kOmega),
          {moments.x, moments.y, moments.z, products.x, products.y, products.z}};
}

std::size_t Plan::get_workspace_bytes() const {
  Workspace scratch;
  return lay_out(*this, nullptr, scratch);
}

}  // namespace unlatch
