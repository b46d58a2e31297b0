// What goes into a step and what comes out of it: inputs; status, the events that acted and their audit, and what the
// search for events left open.
#pragma once

#include <cstdint>
#include <span>

#include "unlatch/energy.h"
#include "unlatch/workspace.h"

namespace unlatch {

// What is commanded during one step.
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
  kRigidContact,   // rigid contacts have no common motion, or overlap where they are switched on; `contact` says
                   // which
};
// The status in words.
const char* get_status_text(StepStatus status) noexcept;

// One event that acted during the step.
struct FiredEvent {
  std::int32_t event;  // index into the model's events
  double time;         // s
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
  std::int32_t corners = 0;      // of laws at which the step was not split, because it has been at others
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
  std::int32_t contact = kNone;         // kRigidContact: index of the contact
  bool wedged = false;                  // likewise: its friction leaves its normal force undecided (Painlevé)
  bool degenerate = false;              // likewise: shapes overlap beyond their radii, or axes of capsules are parallel
  std::int32_t settled = 0;             // bounces of rigid contacts whose flight would be shorter than Contact::settle
  std::int32_t settling = kNone;        // index of the contact of the latest of these
  double yielded = 0;                   // part of the speeds to which a blow on rough feet is known, the worst of them
  std::int32_t yielding = kNone;        // index of a contact of this blow
  std::int32_t substeps = 0;            // integrations done, 1 without events
  std::int32_t redundant = 0;           // rows of closed loops that follow from the others, at the end of the step
  std::int32_t postponed = 0;           // instants left to the next tick because the bound on splits was reached
  OpenSearch open;                      // of events within the step
  std::span<const FiredEvent> events;   // in the order in which they acted; lives in the workspace until the next step
  std::span<const EventAudit> audits;   // one for each instant with events; in the workspace until the next step
};

}  // namespace unlatch
