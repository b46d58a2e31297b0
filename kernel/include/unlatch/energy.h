// Momenta, energies and powers of a state, for the audit of a run: between two instants without events,
//
//   change of (kinetic + strain + dissipated) = ∫ Σ powers dt,
//
// for any method that moves the bodies. The powers are those that are not conservative; springs and modes appear in
// what they store. O(n); an observer calls these, the step does not.
#pragma once

#include <cstdint>

#include "unlatch/math.h"
#include "unlatch/plan.h"
#include "unlatch/state.h"
#include "unlatch/workspace.h"

namespace unlatch {

// Momenta and energies of the whole system, inertial frame.
struct Balance {
  Vec3 momentum;          // kg m/s
  Vec3 angular_momentum;  // about W's origin, kg m²/s
  double kinetic;         // J
};

// Sources of power that an audit lists by themselves.
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
  Vec3 force[kPowerSources];    // N: an observer who moves with v sees each power less by force · v
};

// An observer in whose frame the energy is that of separation and rotation alone.
struct AuditFrame {
  bool grounded = false;   // a joint or an element that is on holds a body to the ground
  Vec3 velocity{0, 0, 0};  // m/s, world axes: 0 if grounded, because the ground does no work only where it is at rest;
                           // else that of the centre of mass
};
// The observer of a state, with the evaluation that the latest step() or update_outputs() left in the workspace.
AuditFrame calc_audit_frame(const Plan& plan, const State& state, const Workspace& workspace) noexcept;

// Energies and powers of the state that the latest step() or update_outputs() left in the workspace, seen by an
// observer with the constant velocity `frame`, world axes, m/s.
EnergyFlow calc_energy_flow(const Plan& plan, const State& state, const Workspace& workspace,
                            const Vec3& frame) noexcept;
// The same, seen by another observer: `change` is added to the velocity of the first.
EnergyFlow change_frame(const EnergyFlow& flow, const Vec3& change) noexcept;

// Largest position residual of the rows that hold, m or rad, of that state. The projections keep it near rounding.
double calc_drift(const Plan& plan, const State& state, const Workspace& workspace) noexcept;

}  // namespace unlatch
