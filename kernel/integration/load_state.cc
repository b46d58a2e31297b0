#include "kernel/integration/load_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "kernel/elements/kinds/one_sided/one_sided.h"
#include "kernel/joints/kinematics.h"
#include "kernel/joints/residuals.h"

namespace unlatch {
namespace {

static_assert(sizeof(BodyState) == sizeof(MotionT<double>));
static_assert(offsetof(JointState, locked) == offsetof(JointState, offset) + sizeof(Vec3));  // compared as one

double get_mask(bool holds) { return std::bit_cast<double>(holds ? ~std::uint64_t{0} : std::uint64_t{0}); }

template <class Do>
void for_rows(RowSet rows, const Do& act) {
  for (unsigned left = rows; left != 0; left &= left - 1) act(std::countr_zero(left));
}

// Lanes without a body are at rest, away from the centre of gravity, where the field has no value. Those of them that
// belong to no group get no acceleration from a solve: it is 0 from here on.
void load_empty_lanes(const PlanData& plan, const BodyEight& eight, double* blocks) {
  const Vec3& c = plan.gravity.centre;
  const Vec3 away{std::abs(c.x) < 1 ? c.x + 1 : 0, c.y, c.z};
  for (int lane = 0; lane < kEight; ++lane) {
    if ((eight.filled >> lane & 1) != 0) continue;
    const Place place{0, 0, eight.body + lane, eight.shared + lane, kEight};
    write(blocks, place, &BodyLane::motion, {away, {1, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
    write(blocks, place, &SharedLane::acceleration, {{0, 0, 0}, {0, 0, 0}});
  }
}

// One lane's mode. `rows`: those that hold; 0 for an empty lane.
void load_lane(const PlanData& plan, const State& state, const Group& group, int joint, RowSet rows, double* blocks,
               const Place& place, GroupModes& modes) {
  const bool by_freedoms = joint != kNone && is_by_freedoms(rows, group.compliant);
  write(blocks, place, &SolverLane::by_freedoms, get_mask(by_freedoms));
  (by_freedoms ? modes.by_freedoms : modes.by_rows) = true;
  const RowSet freedoms = by_freedoms ? static_cast<RowSet>(group.freedoms & ~rows) : RowSet{0};
  const RowSet holding = by_freedoms ? RowSet{0} : static_cast<RowSet>(group.rows & rows);
  modes.freedoms = static_cast<RowSet>(modes.freedoms | freedoms);
  modes.rows = static_cast<RowSet>(modes.rows | holding);
  const LaneParts parts(group, blocks, place);
  for_rows(group.compliant, [&](int r) {
    parts.pivot(r) = 0;
    parts.freedom(r).write(&FreedomBlock<double>::acceleration, 0.0);  // where the mode holds it, no pass writes it
  });
  for_rows(group.freedoms,
           [&](int r) { parts.freedom(r).write(&FreedomBlock<double>::mask, get_mask(has_row(freedoms, r))); });
  for_rows(group.rows, [&](int r) { parts.row(r).write(&RowBlock<double>::mask, get_mask(has_row(holding, r))); });
  const JointState* memory = joint == kNone ? nullptr : &state.joints[at(joint)];
  parts.carried().write(&CarriedBlock<double>::offset, memory == nullptr ? Vec3{0, 0, 0} : memory->offset);
  int kept = 0;
  for (int a = 0; a < 3; ++a) {
    if ((group.carried >> a & 1) == 0) continue;
    parts.carried_axis(kept++).write(memory == nullptr ? Vec3{0, 0, 0}
                                                       : calc_carried_axis(plan.joints[at(joint)], *memory, rows, a));
  }
  if (group.universal) parts.crossed() = get_mask(joint != kNone && is_crossed(plan.joints[at(joint)], rows));
}

}  // namespace

bool has_same_modes(const State& a, const State& b) noexcept {
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    const JointState &x = a.joints[j], &y = b.joints[j];
    if (x.mode != y.mode || std::memcmp(&x.offset, &y.offset, sizeof(x.offset) + sizeof(x.locked)) != 0) return false;
  }
  return true;
}

void load_motion(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  double* blocks = ev.blocks.data();
  for (const BodyEight& eight : plan.eights)
    if (eight.filled != 0xff) load_empty_lanes(plan, eight, blocks);
  for (std::size_t b = 0; b < plan.places.size(); ++b) {
    const BodyState& body = state.bodies[b];
    write(blocks, plan.places[b], &BodyLane::motion, {body.p, body.q, body.v, body.w});
  }
  std::copy(state.auxiliary.begin(), state.auxiliary.end(), ev.auxiliary.now.begin());
}

void load_state(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  load_motion(plan, state, ev);
  load_modes(plan, state, ev);
}

void load_modes(const PlanData& plan, const State& state, Evaluation& ev) noexcept {
  for (std::size_t g = 0; g < plan.groups.size(); ++g) {
    const Group& group = plan.groups[g];
    GroupModes& modes = ev.modes[g] = {0, 0, false, false};
    if (!group.has_joint) {
      modes.by_rows = true;
      continue;
    }
    for (int lane = 0; lane < group.width; ++lane) {
      const int node = plan.lane_nodes[at(group.first + lane)];
      const int joint = node == kNone ? kNone : plan.nodes[at(node)].joint;
      const RowSet rows = joint == kNone ? RowSet{0} : get_active_rows(plan, state, joint);
      load_lane(plan, state, group, joint, rows, ev.blocks.data(), get_place(group, lane), modes);
    }
  }
}

void store_motion(const PlanData& plan, const Evaluation& ev, State& state) noexcept {
  for (std::size_t b = 0; b < plan.places.size(); ++b) {
    const MotionT<double> motion = read(ev.blocks.data(), plan.places[b], &BodyLane::motion);
    state.bodies[b] = {motion.p, motion.q, motion.v, motion.w};
  }
  std::copy(ev.auxiliary.now.begin(), ev.auxiliary.now.end(), state.auxiliary.begin());
}

void store_substep(const PlanData& plan, const Evaluation& ev, State& state) noexcept {
  store_motion(plan, ev, state);
  for (std::size_t i = 0; i < plan.coordinates.size(); ++i) {
    const PlanCoordinate& c = plan.coordinates[i];
    if (c.row >= kRotX) state.joints[at(c.joint)].angle[c.row - kRotX] = ev.coordinates[i];
  }
  store_bearings(plan, ev, state);
}

bool is_finite(const State& state, std::span<const double> sensors) noexcept {
  double sum = 0;
  for (const BodyState& b : state.bodies)
    sum += ((b.p.x + b.p.y) + (b.p.z + b.q.w)) + ((b.q.x + b.q.y) + (b.q.z + b.v.x)) +
           ((b.v.y + b.v.z) + (b.w.x + b.w.y)) + b.w.z;
  for (const JointState& j : state.joints)
    sum += (j.angle[0] + j.angle[1]) + (j.angle[2] + j.offset.x) + (j.offset.y + j.offset.z);
  for (const double number : state.auxiliary) sum += number;
  for (const double number : state.bearings) sum += number;
  for (const double number : sensors) sum += number;
  return std::isfinite(sum);
}

}  // namespace unlatch
