// A copy of a state, with its own memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "unlatch/plan.h"
#include "unlatch/state.h"

namespace unlatch {

struct StateCopy {
  StateCopy(const Plan& plan, const State& other)
      : words(plan.get_state_bytes() / sizeof(std::uint64_t)), state(plan, std::as_writable_bytes(std::span(words))) {
    std::ranges::copy(other.get_bytes(), state.get_bytes().begin());
  }
  std::vector<std::uint64_t> words;
  State state;
};

}  // namespace unlatch
