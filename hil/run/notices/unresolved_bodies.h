// Bodies whose motion depends on something that the step did not resolve: the bodies of a contact, a spring, a rate, a
// search, and every body that joints or forces connect to them, then or later. Conservative: a joint with any row
// connects its two bodies, and so does an element between them that acts (a spring, a pusher, a cord, a stop, a closed
// contact); the ground connects nothing.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "hil/scenario/requirements.h"
#include "unlatch/model.h"
#include "unlatch/plan.h"
#include "unlatch/readings.h"
#include "unlatch/state.h"

namespace unlatch::hil {

class UnresolvedBodies {
 public:
  // Keeps references to both.
  UnresolvedBodies(const Model& model, const Plan& plan);

  // Adds a cause that reached these bodies at a time, s. Each body keeps its first cause.
  void add(std::span<const int> bodies, const std::string& cause, double time, const State& state);
  // Spreads causes through the joints that hold and the elements that act now. Called after events.
  void spread(const State& state, double time);

  [[nodiscard]] bool is_empty() const { return first_ == kNever; }
  // Cause on which the requirement's value depends, for an interval that ends at `until`, s; empty if there is none.
  [[nodiscard]] std::string find_cause(const Requirement& requirement, double until) const;

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  struct Entry {
    double time = kNever;
    std::string cause;
  };
  [[nodiscard]] std::vector<std::vector<int>> list_links(const State& state, double time) const;
  [[nodiscard]] std::vector<int> list_bodies(const Requirement& requirement) const;

  const Model& model_;
  const Plan& plan_;
  std::vector<Entry> bodies_;
  double first_ = kNever;  // s
};

std::vector<int> list_contact_bodies(const Model& model, int contact);
// Every body.
std::vector<int> list_all_bodies(const Model& model);

}  // namespace unlatch::hil
