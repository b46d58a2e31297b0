#include "hil/run/audit/unresolved_bodies.h"

#include <algorithm>

#include "hil/run/audit/dependence.h"
#include "hil/scenario/base/index.h"

namespace unlatch::hil {

UnresolvedBodies::UnresolvedBodies(const Model& model) : model_(model), bodies_(model.bodies.size()) {}

void UnresolvedBodies::add(std::span<const int> bodies, const std::string& cause, double time) {
  for (const int body : bodies) {
    Entry& entry = bodies_[at(find_carrier(model_, body))];
    if (time < entry.time) entry = {time, cause};
  }
  first_ = std::min(first_, time);
}

void UnresolvedBodies::add_passed(int body, const std::string& cause, double from, double until,
                                  const BodyLinks& links) {
  std::vector<double> times(bodies_.size(), kNever);
  times[at(find_carrier(model_, body))] = from;
  std::vector<int> sources;
  links.spread(times, sources);
  for (std::size_t b = 0; b < times.size(); ++b)
    if (times[b] <= until) passed_.push_back({static_cast<int>(b), times[b], until, cause});
}

void UnresolvedBodies::add_speed(const SpeedReaders& readers, const std::string& cause, double from, double until) {
  speeds_.push_back({readers, from, until, cause});
}

void UnresolvedBodies::spread(const BodyLinks& links) {
  if (first_ == kNever) return;
  std::vector<double> times;
  for (const Entry& entry : bodies_) times.push_back(entry.time);
  std::vector<int> sources;
  links.spread(times, sources);
  const std::vector<Entry> own = bodies_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) bodies_[b] = {times[b], own[at(sources[b])].cause};
}

std::string UnresolvedBodies::find_cause(const Requirement& requirement, double until, double time) const {
  for (const Speed& speed : speeds_)
    if (speed.readers.is_read_by(requirement) && speed.from <= until && time <= speed.until) return speed.cause;
  if (first_ == kNever && passed_.empty()) return "";
  const Entry* first = nullptr;
  const std::vector<int> bodies = list_bodies(model_, requirement);
  for (const int body : bodies) {
    const Entry& entry = bodies_[at(find_carrier(model_, body))];
    if (entry.time <= until && (first == nullptr || entry.time < first->time)) first = &entry;
  }
  if (first != nullptr && first->time != kNever) return first->cause;
  for (const Passed& passed : passed_)
    for (const int body : bodies)
      if (find_carrier(model_, body) == passed.body && passed.from <= time && time <= passed.until) return passed.cause;
  return "";
}

}  // namespace unlatch::hil
