// Differences between two states of one model, field by field and by name, to the last bit.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/session/messages/messages.h"
#include "unlatch/model.h"
#include "unlatch/state.h"

namespace unlatch::hil {

struct FieldDifference {
  std::string of;              // "body 'core'", "joint 'nose1'", "element 'main1'", "event 'release booster1'", …
  std::string field;           // "p.x", "mode", …
  bool real = true;            // else an integer
  std::uint64_t a = 0, b = 0;  // the bits
  [[nodiscard]] double get_a() const { return get(a); }
  [[nodiscard]] double get_b() const { return get(b); }
  // Doubles between the two, plus one; absent for integers, and if one is no number.
  [[nodiscard]] std::optional<std::uint64_t> calc_ulps() const;

 private:
  [[nodiscard]] double get(std::uint64_t bits) const {
    return real ? std::bit_cast<double>(bits) : static_cast<double>(static_cast<std::int64_t>(bits));
  }
};

// Fields whose bits differ, in the order of the block: bodies, joints, elements, events, signals. Both states must be
// of `model`'s plan.
std::vector<FieldDifference> compare_states(const Model& model, const State& a, const State& b);
// Fields of State messages whose bits differ: bodies, sensor values, joint modes. Both must be the same part of a tick.
std::vector<FieldDifference> compare_states(const Model& model, const StateMessage& a, const StateMessage& b);

}  // namespace unlatch::hil
