// State: exactly what decides the next step, in one flat block that the caller owns. Copy it with memcpy, hash it, save
// it, move it: the step gives the same bits. Every field is 8 bytes wide, so the block has no padding.
//
//   [StateHeader][BodyState × bodies][JointState × joints][ElementState × elements][EventState ×
//   events][signals][auxiliary][ContactState × pairs][one-sided forces][drums]
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "unlatch/math.h"

namespace unlatch {

class Plan;

// Tick of the state, and the plan to which it belongs.
struct StateHeader {
  std::int64_t tick;        // time is tick · dt, never a running sum
  std::uint64_t plan_hash;  // of the plan that this state belongs to
};

// Pose and velocity of a body.
struct BodyState {
  Vec3 p;  // p_WB, m
  Quat q;  // q_WB, body to inertial
  Vec3 v;  // v_WB, inertial axes, m/s
  Vec3 w;  // w_WB_B, body axes, rad/s
};

// Memory of a joint.
struct JointState {
  std::int64_t mode;  // index into the joint's modes
  // About the axes of the rotation frame, turns counted, at the start of the step, rad; 0 if it is not read.
  double angle[3];
  Vec3 offset;  // where the point–plane rows hold, along x, y, z of the joint frame, m
  Quat locked;  // relative attitude at which three rotation rows hold: rotation frame, follower to base
};

// An element's switch scale runs linearly from `from` at `start` to `to` at `start + duration` and stays there.
struct ElementState {
  double switched_on;  // when its own time began, s
  // Switch scale before and after a change; start and duration of the change, s.
  double from, to, start, duration;
};

// An element's switch scale at time t, s.
inline double calc_scale(const ElementState& element, double t) noexcept {
  const double elapsed = t - element.start;
  if (!(elapsed < element.duration)) return element.to;
  return element.from + (element.to - element.from) * (elapsed / element.duration);
}

// Progress of an event.
enum class EventPhase : std::int64_t {
  kArmed = 0,    // waits for its guard
  kPending = 1,  // crossed; acts when due
  kSpent = 2,    // has acted; a repeating event arms again once its guard is negative
};
// Progress of an event, and the time at which it acts.
struct EventState {
  EventPhase phase;  // progress
  double due;        // kPending: s; otherwise 0, or if some quantity is the time since it acted: when, −1 before, s
};

// Memory of one pair of shapes of a contact.
struct ContactState {
  std::int64_t closed;  // 1: from touch to lift; of a rigid contact with friction 3: it sticks, 4: its slip begins or
                        // ends, likewise; within an instant 2: of a rigid contact, it bounces
  double edge;          // m, distance at which that changes next: 0, but for the rounding of the last change
};

static_assert(sizeof(ContactState) == 16 && sizeof(StateHeader) == 16 && sizeof(BodyState) == 104 &&
              sizeof(JointState) == 88 && sizeof(ElementState) == 40 && sizeof(EventState) == 16);

// A view of one state block. Copying the view does not copy the state.
class State {
 public:
  State() = default;
  // `memory`: at least plan.get_state_bytes(), aligned to 8.
  State(const Plan& plan, std::span<std::byte> memory) noexcept;

  StateHeader* header = nullptr;     // tick and plan
  std::span<BodyState> bodies;       // in the model's order
  std::span<JointState> joints;      // in the model's order
  std::span<ElementState> elements;  // in the order of the model's one numbering
  std::span<EventState> events;      // in the model's order
  std::span<double> signals;         // values, in the model's order
  std::span<double> auxiliary;  // kg burnt by each body with a mass law; then per flexible body its modal coordinates,
                                // and their rates, 1/s; then the ContactTotals of each contact
  std::span<ContactState> contacts;  // of each contact in the model's order, each pair of its shapes: those of the
                                     // base, with each of them those of the follower
  std::span<std::int64_t> engaged;   // one-sided forces, in the model's order: 1 while engaged, else 0
  std::span<double> rigid_forces;    // per pair of shapes, none without rigid contacts: normal force of a rigid
                                     // contact's closed pair at the end of the step, N; else 0
  // Per pair of shapes, none without rigid contacts that have friction, W: a unit vector, the direction of the slip
  // where it begins or ends, elsewhere that of one of its two rows; friction on the follower at the end of the step, N.
  std::span<Vec3> rigid_slips, rigid_frictions;
  std::span<double> bearings;  // of the ends of cords with drums, in the model's order: CordPath::bearing at the
                               // start of the step, rad

  // The whole block.
  std::span<std::byte> get_bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

// The model's initial state at tick 0.
void init_state(const Plan& plan, State& state) noexcept;

// The modal coordinates of a flexible body; empty for any other.
std::span<const double> get_modal_coordinates(const Plan& plan, const State& state, int body) noexcept;

// 64-bit hash of every bit of the state; the same on every machine.
std::uint64_t calc_hash(const State& state) noexcept;

}  // namespace unlatch
