// Coordinates beyond the bodies: what has been burnt, and modal coordinates with their rates. First-order scalars that
// go through the stages of a step beside the bodies; as the lanes' stages do, see lane_kernels.h.
#pragma once

#include "kernel/plan/workspace.h"
#include "unlatch/plan.h"

namespace unlatch {

void load_extras(const State& state, Workspace& ws) noexcept;
void store_extras(const Workspace& ws, State& state) noexcept;

void keep_extras(Workspace& ws) noexcept;
void begin_extras(Workspace& ws, double weight, double h) noexcept;
void advance_extras(Workspace& ws, double weight, double h) noexcept;
void finish_extras(Workspace& ws, double weight, double h) noexcept;

// With implicit elements: back to the beginning; to the second stage, the sum being half the first one's rates.
void restart_extras(Workspace& ws) noexcept;
void begin_second_extras(Workspace& ws, double h) noexcept;

}  // namespace unlatch
