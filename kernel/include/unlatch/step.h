// One step: t = tick · dt → (tick + 1) · dt. Read kernel/step/step.cc top to bottom.
#pragma once

#include <cstdint>
#include <span>

#include "unlatch/motion.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Inputs of one step.
struct Inputs {
  std::span<const double> commands;  // one value per channel of the model, in its order
};

// Result of a step.
enum class StepStatus : std::int32_t {
  kOk = 0,         // done
  kNotFinite,      // a number of the new state is not finite
  kSingular,       // a pivot of the factorisation vanished; `joint` says where
  kTooManyEvents,  // more events at one instant than the plan's bound
  kOutsideTable,   // a table whose ends are errors was left; `table` says which
};
// The status in words.
const char* get_status_text(StepStatus status) noexcept;

// Size of a load (its number in the model) at the state's tick: profile · switch scale · command, N or N m per length
// of its direction. `workspace`: with the outputs of this state.
double calc_load_size(const Plan& plan, const Inputs& inputs, const State& state, const Workspace& workspace,
                      int load) noexcept;

// One event that acted during the step.
struct FiredEvent {
  std::int32_t event;  // index into the model's events
  double time;         // s
};

// Momenta and energies of the whole system, inertial frame.
struct Balance {
  Vec3 momentum;          // kg m/s
  Vec3 angular_momentum;  // about W's origin, kg m²/s
  double kinetic;         // J
};

// Sources of power that an audit tells apart.
enum class PowerSource : std::int32_t {
  kLoads,      // forces and torques that a law or a command sizes
  kGravity,    // weight
  kMotors,     // constant efforts of joint springs, and joint torsions while no hinge makes them conservative
  kDampers,    // of springs; what a pusher loses that may not pull
  kModes,      // damping of flexible bodies
  kMass,       // kinetic energy of what leaves a body with a mass law, and jet damping
  kSwitching,  // springs whose switch scale runs
};
inline constexpr int kPowerSources = 7;                     // number of them
extern const char* const kPowerSourceNames[kPowerSources];  // "loads" …

// Energies and powers of the whole system at one instant, for one observer, see unlatch/energy.h.
struct EnergyFlow {
  double mass, mass_rate;       // kg, kg/s
  Vec3 momentum;                // kg m/s
  double kinetic, strain;       // J; strain: stored in springs, modes and contacts, at their switch scales
  double dissipated;            // J lost in contacts since the start
  double power[kPowerSources];  // W, by PowerSource
  Vec3 force[kPowerSources];    // N: how much an observer who moves with v sees less of each power, per v
};

// One instant at which events acted, audited: `jump` is what changed, `allowed` what the actions may change: nothing
// for a release, the work and ground impulse of a plastic impulse for rows that close.
struct EventAudit {
  double time;  // s
  // Balance before the events, its change, and the change that the actions are allowed to make.
  Balance before, jump, allowed;
  // Energies and powers just before and just after, for an observer at rest.
  EnergyFlow flow_before, flow_after;
};

// Parts of the search for events within a step that were left open, because a bound on its work was reached.
struct OpenSearch {
  std::int32_t unlocated = 0;    // instants of events that are known worse than to the tolerance of the search
  double interval = 0;           // s, that holds the worst known of them
  std::int32_t guard = kNone;    // it: index into the model's events, then into its contacts, whatever pairs these have
  std::int32_t unseen = 0;       // pairs of shapes that may have touched and parted again
  double depth = 0;              // m: no pair whose distance is convex over time has touched deeper than this
  std::int32_t contact = kNone;  // the contact of the pair that may have been as deep: index into the model's contacts
};

// Report of a step.
struct StepReport {
  StepStatus status = StepStatus::kOk;  // result
  std::int32_t joint = kNone;           // kSingular: index of the joint
  std::int32_t table = kNone;           // kOutsideTable: index of the table
  TableExit exit{};                     // likewise: the axis and the coordinate
  std::int32_t substeps = 0;            // integrations done, 1 without events
  std::int32_t redundant = 0;           // rows of closed loops that follow from the others, at the end of the step
  std::int32_t postponed = 0;           // instants left to the next tick because the bound on splits was reached
  OpenSearch open;                      // of events within the step
  std::span<const FiredEvent> events;   // in the order in which they acted; lives in the workspace until the next step
  std::span<const EventAudit> audits;   // one for each instant with events; in the workspace until the next step
};

// Advances `state` by one tick. Quicker by a tenth where the latest call with this workspace left its outputs of this
// very state: the bits are the same. On any status but kOk the state is unchanged. Allocates nothing, takes no lock,
// makes no system call. `log`, if given, gets the knots of the motion inside the step; the bits are the same without.
[[nodiscard]] StepReport step(const Plan& plan, const Inputs& inputs, State& state, Workspace& workspace,
                              MotionLog* log = nullptr) noexcept;

// The accelerations, reactions and sensor values of a state: what step() leaves in the workspace for its new state,
// here for a state that no step produced, such as the initial one.
[[nodiscard]] StepStatus update_outputs(const Plan& plan, const Inputs& inputs, const State& state,
                                        Workspace& workspace) noexcept;

}  // namespace unlatch
