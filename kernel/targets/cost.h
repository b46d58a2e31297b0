// Instructions of a step and of its parts, as cost.cc prints them. cost_primitives.cc counts the parts, and is linked
// with --wrap (cost.cmake); cost_steps.cc counts whole steps alone.
#pragma once

#include <cstdint>

#include "kernel/plan/plan_data.h"

namespace unlatch::target {

// Before the first step of a plan; around each step; after the last one. Counts are in units of kInstructionUnit.
void begin_primitives(const PlanData& plan);
std::uint64_t begin_step();
std::uint64_t end_step(std::uint64_t begin);
void print_primitives(const char* plan);

}  // namespace unlatch::target
