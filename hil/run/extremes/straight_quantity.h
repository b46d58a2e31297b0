// Quantities that are straight lines between events: signals, modes, what is engaged or closed, commands, times and
// scales of switches. No polynomial through their knots is right beside an event; their extremes are at knots.
#pragma once

#include "unlatch/quantities.h"

namespace unlatch::hil {

inline bool is_straight(const QuantityTraits& traits) {
  return (traits.reads & kReadsEvents) != 0 || traits.motion == QuantityMotion::kOfNone;
}

}  // namespace unlatch::hil
