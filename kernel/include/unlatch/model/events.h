// Events of a model: conditions on quantities, and the actions that follow when one becomes true.
#pragma once

#include <string>
#include <vector>

namespace unlatch {

// A guard is a real function of the state. It holds while it is ≥ 0, and an event occurs where it crosses zero upwards.
// kAll is the least of its parts, kAny the greatest, kNot the negative.
struct Condition {
  // Quantity that is compared with the threshold, or how the parts are combined.
  enum class Kind {
    kTime,           // t ≥ threshold
    kReaction,       // multiplier of row `axis` of a joint; never holds while that row is inactive
    kDisplacement,   // of a joint along row `axis`
    kAngle,          // of a joint about row `axis`
    kSpeed,          // rate of either
    kBodyRate,       // |angular velocity| of a body
    kSignal,         // a signal is raised
    kCommand,        // a channel's value
    kMode,           // a joint is in mode number `axis`
    kAll,            // all parts hold
    kAny,            // at least one part holds
    kNot,            // its one part does not hold
    kBurnt,          // what a body with a mass law has burnt, kg
    kDistance,       // signed distance of surfaces `subject` and `axis`, m
    kClosed,         // a contact is closed: some pair of its shapes
    kForceSize,      // |multipliers of x, y, z| of a joint, N; 0 while none is active
    kMomentSize,     // |multipliers of rot_x, rot_y, rot_z| of a joint, N m; likewise
    kOneSidedForce,  // of a one-sided force (its number among these) at its switch scale, N or N m; 0 while not engaged
    kEngaged,        // a one-sided force is engaged
    kReach,          // for complete_events(): depth or force of a one-sided force, whichever is less
    kWound,          // angle by which a cord (its number among one-sided forces) is wound on its drum, rad; negative
                     // for a straight cord: the angle from it to the tangent
    kBearing,        // of a cord's end about its drum's axis from its anchor, turns counted, rad
    kQuantity,       // quantity number `subject` of the model
  };
  Kind kind = Kind::kTime;       // kind
  int subject = 0;               // index of the joint, body, signal, channel, surface, contact or quantity
  int axis = 0;                  // Row of a joint; kMode: index of the mode; kDistance: index of the other surface
  double threshold = 0;          // in the unit of the quantity
  bool below = false;            // holds at and below the threshold instead of at and above it
  std::vector<Condition> parts;  // of kAll, kAny, kNot
};

// An action of an event.
struct Action {
  // Kind of action.
  enum class Kind {
    kSetMode,  // rows that are added close where they are, with a perfectly plastic impulse
    kSwitch,   // element `subject` to scale `value`; if it was at zero, its own time begins
    kRamp,     // the same, linearly over `duration` seconds
    kRaise,    // signal `subject` to `value`
    kImpulse,  // impulse `subject` of the model acts
    kEngage,   // for complete_events(): one-sided force `subject` becomes engaged (value 1) or not engaged (0)
  };
  Kind kind = Kind::kSetMode;  // kind
  int subject = 0;             // joint, element, signal, impulse or one-sided force
  int mode = 0;                // kSetMode: index into the joint's modes
  double value = 0;            // kSwitch, kRamp: scale; kRaise: value of the signal
  double duration = 0;         // s
};

// A condition, and the actions that follow when it becomes true.
struct Event {
  std::string name;          // name and subject together are unique
  std::string subject;       // what it concerns, for readers: "booster1"
  Condition when;            // guard
  double delay = 0;          // s between the guard's crossing and the actions
  std::vector<Action> then;  // actions, in order
  bool repeat = false;       // fires again each time the guard crosses upwards; otherwise once
  bool crossing = false;     // of a repeating event: a guard that holds at the start does not fire it
};

}  // namespace unlatch
