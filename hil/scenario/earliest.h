// Earliest times at which events can occur, from known times, delays and what depends on what.
#pragma once

#include <string>
#include <vector>

#include "unlatch/model.h"

namespace unlatch::hil {

class EarliestTimes {
 public:
  explicit EarliestTimes(const Model& model);

  // Of an event's actions, s; infinity if no event brings about what it waits for. Conditions on motion may hold at any
  // time.
  [[nodiscard]] double get_event(std::size_t event) const { return events_[event]; }
  // Why an event does not occur by `until`, s: "cannot come before 3 s; the run ends at 2 s"; empty if it may.
  [[nodiscard]] std::string explain(std::size_t event, double until) const;

 private:
  void settle();
  [[nodiscard]] double calc(const Condition& condition) const;
  [[nodiscard]] double calc(const unlatch::Quantity& quantity, const Condition& condition) const;

  const Model& model_;
  std::vector<double> events_, signals_;
  std::vector<std::vector<double>> modes_;  // of each joint
};

}  // namespace unlatch::hil
