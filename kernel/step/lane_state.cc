#include "kernel/step/lane_state.h"

#include <bit>
#include <cmath>

#include "kernel/dynamics/kinematics.h"
#include "kernel/dynamics/rows.h"
#include "kernel/plan/lane_access.h"

namespace unlatch {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

static_assert(sizeof(BodyState) == (kStart - kPose) * sizeof(double));

// All bits or none: what the kernels' masks are made of.
double get_mask(bool holds) { return std::bit_cast<double>(holds ? ~std::uint64_t{0} : std::uint64_t{0}); }

bool has_three(RowSet rows) {
  const RowSet without_one = rows & static_cast<RowSet>(rows - 1);
  return (without_one & static_cast<RowSet>(without_one - 1)) != 0;
}

template <class Do>
void for_rows(RowSet rows, const Do& act) {
  for (unsigned left = rows; left != 0; left &= left - 1) act(std::countr_zero(left));
}

void load_body(const BodyState& body, double* lanes) {
  const double numbers[] = {body.p.x, body.p.y, body.p.z, body.q.w, body.q.x, body.q.y, body.q.z,
                            body.v.x, body.v.y, body.v.z, body.w.x, body.w.y, body.w.z};
  for (const double number : numbers) {
    *lanes = number;
    lanes += kOctet;
  }
}

// Lanes without a body rest, away from the centre of gravity, where nothing could be computed. No solve gives those of
// them that belong to no group an acceleration.
void load_empty_lanes(const Plan& plan, const LaneOctet& octet, double* lanes) {
  const Vec3& c = plan.mu_centre;
  const Vec3 away{std::abs(c.x) < 1 ? c.x + 1 : 0, c.y, c.z};
  for (int lane = 0; lane < kOctet; ++lane) {
    if ((octet.bodies >> lane & 1) != 0) continue;
    load_body({away, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, lanes + octet.body + kPose * kOctet + lane);
    for (int row = 0; row < 6; ++row) lanes[octet.shared + (kAcceleration + row) * kOctet + lane] = 0;
  }
}

// What one lane's mode makes of its parts. `rows`: that hold; 0 for an empty lane.
void load_lane(const Plan& plan, const State& state, const LaneGroup& group, int joint, RowSet rows, double* lanes,
               LaneSlot slot, LanePhase& phase) {
  const bool held = has_three(rows) || (group.compliant != 0 && joint != kNone);
  get_number(lanes, slot, kHeld) = get_mask(held);
  (held ? phase.held : phase.loose) = true;
  const RowSet freedoms = held ? static_cast<RowSet>(group.freedoms & ~rows) : RowSet{0};
  const RowSet holding = held ? RowSet{0} : static_cast<RowSet>(group.rows & rows);
  phase.freedoms = static_cast<RowSet>(phase.freedoms | freedoms);
  phase.rows = static_cast<RowSet>(phase.rows | holding);
  for_rows(group.compliant, [&](int r) {
    get_number(lanes, slot, group.pivots[r]) = 0;
    get_number(lanes, slot, group.freedom_parts[r] + kBeta) = 0;  // where the mode holds it, nobody else writes it
  });
  for_rows(group.freedoms,
           [&](int r) { get_number(lanes, slot, group.freedom_parts[r] + kMask) = get_mask(has_row(freedoms, r)); });
  for_rows(group.rows,
           [&](int r) { get_number(lanes, slot, group.row_parts[r] + kRowMask) = get_mask(has_row(holding, r)); });
  const JointState* memory = joint == kNone ? nullptr : &state.joints[at(joint)];
  write_vec(lanes, slot, group.carried_axes, memory == nullptr ? Vec3{0, 0, 0} : memory->offset);
  JointField part = group.carried_axes + kOffsetFields;
  for (int a = 0; a < 3; ++a) {
    if ((group.carried >> a & 1) == 0) continue;
    write_vec(lanes, slot, part,
              memory == nullptr ? Vec3{0, 0, 0} : calc_carried_axis(plan.joints[at(joint)], *memory, rows, a));
    part = part + 3;
  }
  if (group.universal)
    get_number(lanes, slot, group.crossed) = get_mask(joint != kNone && is_crossed(plan.joints[at(joint)], rows));
}

}  // namespace

void load_state(const Plan& plan, const State& state, Workspace& ws) noexcept {
  ws.settled = false;
  double* lanes = ws.lanes.data();
  for (const LaneOctet& octet : plan.octets)
    if (octet.bodies != 0xff) load_empty_lanes(plan, octet, lanes);
  for (std::size_t b = 0; b < plan.body_slots.size(); ++b)
    load_body(state.bodies[b], lanes + find(plan.body_slots[b], kPose));
  load_modes(plan, state, ws);
}

void load_modes(const Plan& plan, const State& state, Workspace& ws) noexcept {
  double* lanes = ws.lanes.data();
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    const LaneGroup& group = plan.groups[g];
    LanePhase& phase = ws.phases[g] = {0, 0, false, false, false};
    if (!group.has_joint) {
      phase.loose = true;
      continue;
    }
    for (int lane = 0; lane < group.width; ++lane) {
      const int node = plan.lane_nodes[at(group.first + lane)];
      const int joint = node == kNone ? kNone : plan.nodes[at(node)].joint;
      const RowSet rows = joint == kNone ? RowSet{0} : get_active_rows(plan, state, joint);
      load_lane(plan, state, group, joint, rows, lanes, get_slot(group, lane), phase);
    }
    phase.hinged = !phase.loose && group.compliant == 0 && std::has_single_bit(phase.freedoms);
  }
}

void store_bodies(const Plan& plan, const Workspace& ws, State& state) noexcept {
  const double* lanes = ws.lanes.data();
  for (std::size_t b = 0; b < plan.body_slots.size(); ++b) {
    const LaneSlot slot = plan.body_slots[b];
    state.bodies[b] = {read_vec(lanes, slot, kPose), read_quat(lanes, slot, kPose + 3),
                       read_vec(lanes, slot, kVelocity), read_vec(lanes, slot, kVelocity + 3)};
  }
}

}  // namespace unlatch
