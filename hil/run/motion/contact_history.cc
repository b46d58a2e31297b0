#include "hil/run/motion/contact_history.h"

#include <algorithm>
#include <cstring>

namespace unlatch::hil {
namespace {

void copy(const State& from, const State& to) {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
}

}  // namespace

ContactHistory::Scratch::Scratch(const Plan& plan)
    : block(plan.get_state_bytes() / sizeof(std::uint64_t)), state(plan, std::as_writable_bytes(std::span(block))) {}

ContactHistory::ContactHistory(const Scenario& scenario, const Simulation& simulation)
    : simulation_(simulation), present_(simulation.plan()), previous_(simulation.plan()) {
  for (const Contact& contact : scenario.model.contacts) tracks_.emplace_back().record.name = contact.name;
}

bool ContactHistory::is_closed(const State& state, std::size_t contact) const {
  const std::span<const ContactState> pairs = get_contact_pairs(simulation_.plan(), state, static_cast<int>(contact));
  return std::any_of(pairs.begin(), pairs.end(), [](const ContactState& pair) { return pair.closed != 0; });
}

void ContactHistory::begin(const State& state) {
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    tracks_[i].record.closed = tracks_[i].record.closed_at_start = is_closed(state, i);
}

void ContactHistory::add_events(const MotionKnot& before, const MotionKnot& after) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    ContactRecord& record = track.record;
    const bool was = is_closed(before.state, i), is = is_closed(after.state, i);
    if (was == is) continue;
    record.closed = is;
    track.fresh = true;
    if (is) {
      ++record.touches;
      if (!record.touch) record.touch = after.time;
    } else {
      record.lift = after.time;
      finish(track, static_cast<int>(i));
    }
  }
}

ContactReading ContactHistory::calc(const State& state, int contact) const {
  return calc_contact(simulation_.plan(), state, contact);
}

double ContactHistory::calc(const State& state, int contact, Requirement::ContactValue value) const {
  using Value = Requirement::ContactValue;
  const ContactTotals totals = get_contact_totals(simulation_.plan(), state, contact);
  switch (value) {
    case Value::kForce:
      return calc(state, contact).normal;
    case Value::kDepth:
      return calc(state, contact).depth;
    case Value::kSlip:
      return totals.slip;
    case Value::kImpulse:
      return totals.impulse;
    case Value::kDissipated:
      return totals.dissipated;
  }
  return 0;
}

ContactReading ContactHistory::calc(const MotionWindow& window, int contact, double time) const {
  const State& state = (time < window.get_present().from ? previous_ : present_).state;
  for (std::size_t b = 0; b < state.bodies.size(); ++b) state.bodies[b] = window.calc_body(static_cast<int>(b), time);
  return calc(state, contact);
}

void ContactHistory::finish(Track& track, int contact) const {
  if (window_ == nullptr) return;
  track.force.finish([&](double time) { return -calc(*window_, contact, time).normal; });
  track.depth.finish([&](double time) { return -calc(*window_, contact, time).depth; });
}

void ContactHistory::add(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to) {
  if (tracks_.empty()) return;
  copy(present_.state, previous_.state);
  copy(from.state, present_.state);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    track.record.totals = get_contact_totals(simulation_.plan(), to.state, static_cast<int>(i));
    if (!is_closed(from.state, i)) continue;
    const int contact = static_cast<int>(i);
    const bool begins = track.fresh || !window.is_smooth();
    if (begins && !track.fresh) finish(track, contact);
    const ContactReading at_from = calc(from.state, contact), at_to = calc(to.state, contact);
    track.force.add(from.time, -at_from.normal, to.time, -at_to.normal, begins,
                    [&](double time) { return -calc(window, contact, time).normal; });
    track.depth.add(from.time, -at_from.depth, to.time, -at_to.depth, begins,
                    [&](double time) { return -calc(window, contact, time).depth; });
    track.record.duration += to.time - from.time;
    track.fresh = false;
  }
  window_ = &window;
}

std::vector<ContactRecord> ContactHistory::list() const {
  std::vector<ContactRecord> records;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track track = tracks_[i];
    if (track.record.closed && !track.fresh) finish(track, static_cast<int>(i));
    if (track.force.has_value()) {
      track.record.peak_force = -track.force.get_value();
      track.record.peak_time = track.force.get_time();
      track.record.depth = -track.depth.get_value();
    }
    records.push_back(track.record);
  }
  return records;
}

}  // namespace unlatch::hil
