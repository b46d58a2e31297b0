#include "hil/run/motion/contact_history.h"

#include <algorithm>
#include <cstring>

namespace unlatch::hil {
namespace {

using geometry::ShapeKind;

void copy(const State& from, const State& to) {
  std::memcpy(to.get_bytes().data(), from.get_bytes().data(), from.get_bytes().size());
}

bool is_same(const State& a, const State& b) {
  return std::memcmp(a.get_bytes().data(), b.get_bytes().data(), a.get_bytes().size()) == 0;
}

}  // namespace

std::vector<std::pair<int, int>> list_contact_pairs(const Model& model, const Contact& contact) {
  const std::vector<geometry::Shape>& base = model.surfaces[static_cast<std::size_t>(contact.base)].shapes;
  const std::vector<geometry::Shape>& follower = model.surfaces[static_cast<std::size_t>(contact.follower)].shapes;
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < static_cast<int>(base.size()); ++i)
    for (int k = 0; k < static_cast<int>(follower.size()); ++k) {
      const ShapeKind a = base[static_cast<std::size_t>(i)].kind, b = follower[static_cast<std::size_t>(k)].kind;
      const bool excepted = std::ranges::find(contact.except, std::pair(i, k)) != contact.except.end();
      if (!excepted && geometry::has_distance(a, b)) pairs.emplace_back(i, k);
    }
  return pairs;
}

OwnState::OwnState(const Plan& plan)
    : block(plan.get_state_bytes() / sizeof(std::uint64_t)), state(plan, std::as_writable_bytes(std::span(block))) {}

ContactReadings::ContactReadings(const Plan& plan) : plan_(plan), of_(plan) {}

const ContactReading& ContactReadings::get(const State& state, int contact) {
  const auto number = static_cast<std::size_t>(contact);
  if (!is_same(state, of_.state)) {
    copy(state, of_.state);
    std::ranges::fill(readings_, std::nullopt);
  }
  if (readings_.size() <= number) readings_.resize(number + 1);
  std::optional<ContactReading>& reading = readings_[number];
  if (!reading) reading = calc_contact(plan_, state, contact);
  return *reading;
}

ContactHistory::ContactHistory(const Scenario& scenario, const Simulation& simulation, bool touches)
    : scenario_(scenario),
      simulation_(simulation),
      touches_(touches),
      present_(simulation.plan()),
      previous_(simulation.plan()),
      readings_(simulation.plan()) {
  for (const Contact& contact : scenario.model.contacts) {
    tracks_.emplace_back().record.name = contact.name;
    pairs_.push_back(list_contact_pairs(scenario.model, contact));
  }
  known_.resize(tracks_.size());
}

bool ContactHistory::is_closed(const State& state, std::size_t contact) const {
  const std::span<const ContactState> pairs = get_contact_pairs(simulation_.plan(), state, static_cast<int>(contact));
  return std::any_of(pairs.begin(), pairs.end(), [](const ContactState& pair) { return pair.closed != 0; });
}

std::vector<std::string> ContactHistory::list_closing(const State& before, const State& after,
                                                      std::size_t contact) const {
  const int number = static_cast<int>(contact);
  const Contact& own = scenario_.model.contacts[contact];
  const std::span<const ContactState> was = get_contact_pairs(simulation_.plan(), before, number);
  const std::span<const ContactState> is = get_contact_pairs(simulation_.plan(), after, number);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < is.size(); ++i) {
    if (is[i].closed == 0 || (&before != &after && was[i].closed != 0)) continue;
    const auto [base, follower] = pairs_[contact].at(i);
    names.push_back(name_surface_shape(scenario_, own.base, base) + " – " +
                    name_surface_shape(scenario_, own.follower, follower));
  }
  return names;
}

void ContactHistory::begin(double time, const State& state) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].record.closed = tracks_[i].record.closed_at_start = is_closed(state, i);
    if (!tracks_[i].record.closed) continue;
    open_touch(tracks_[i], i, time, state, state);
    if (tracks_[i].kept) tracks_[i].record.list.back().at_start = true;
  }
}

// `before`: the state just before, or `state` itself for one that no step produced.
void ContactHistory::open_touch(Track& track, std::size_t contact, double time, const State& before,
                                const State& state) {
  track.kept = touches_ && track.record.list.size() < ContactRecord::kMostTouches;
  if (!track.kept) return;
  track.own_force = track.own_depth = Smallest();
  track.impulse = get_contact_totals(simulation_.plan(), state, static_cast<int>(contact)).impulse;
  Touch& touch = track.record.list.emplace_back();
  touch.time = time;
  touch.pairs = list_closing(before, state, contact);
}

// Sets the results of a touch that ends, or that is asked for before its end.
void ContactHistory::close_touch(Track& track, int contact, Touch& touch) const {
  if (window_ != nullptr && !track.fresh) {
    track.own_force.finish([&](double time) { return -calc(*window_, contact, time).normal; });
    track.own_depth.finish([&](double time) { return -calc(*window_, contact, time).depth; });
  }
  touch.impulse = track.record.totals.impulse - track.impulse;
  if (!track.own_force.has_value()) return;
  touch.peak_force = -track.own_force.get_value();
  touch.peak_time = track.own_force.get_time();
  touch.depth = -track.own_depth.get_value();
}

void ContactHistory::add_events(const MotionKnot& before, const MotionKnot& after) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    ContactRecord& record = track.record;
    const bool was = is_closed(before.state, i), is = is_closed(after.state, i);
    if (was && is && track.kept)
      for (std::string& name : list_closing(before.state, after.state, i)) {
        std::vector<std::string>& pairs = record.list.back().pairs;
        if (std::ranges::find(pairs, name) == pairs.end()) pairs.push_back(std::move(name));
      }
    if (!was && !is) add_bounce(track, i, before, after);
    if (was == is) continue;
    record.closed = is;
    if (is) {
      track.fresh = true;
      ++record.touches;
      if (!record.touch) record.touch = after.time;
      open_touch(track, i, after.time, before.state, after.state);
    } else {
      record.lift = after.time;
      finish(track, static_cast<int>(i));
      if (track.kept) {
        record.list.back().lift = after.time;
        close_touch(track, static_cast<int>(i), record.list.back());
      }
      track.fresh = true;
      track.kept = false;
    }
  }
}

// A rigid contact that touched and left again at one instant, which its impulse shows.
void ContactHistory::add_bounce(Track& track, std::size_t contact, const MotionKnot& before, const MotionKnot& after) {
  if (!scenario_.model.contacts[contact].rigid) return;
  const auto get_totals = [&](const MotionKnot& knot) {
    return get_contact_totals(simulation_.plan(), knot.state, static_cast<int>(contact));
  };
  const double impulse = get_totals(after).impulse - get_totals(before).impulse;
  if (!(impulse > 0)) return;
  ContactRecord& record = track.record;
  record.totals = get_totals(after);
  ++record.touches;
  if (!record.touch) record.touch = after.time;
  record.lift = after.time;
  if (!touches_ || record.list.size() >= ContactRecord::kMostTouches) return;
  Touch& touch = record.list.emplace_back();
  touch.time = after.time;
  touch.lift = after.time;
  touch.impulse = impulse;
}

void ContactHistory::add_settled(int bounces, std::span<const MotionKnot> knots) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Contact& contact = scenario_.model.contacts[i];
    if (!contact.rigid) continue;
    double fastest = 0;
    for (const MotionKnot& knot : knots) fastest = std::max(fastest, calc(knot.state, static_cast<int>(i)).slip);
    const double flight = contact.settle.value_or(0.5 * scenario_.dt);
    if (fastest > 0)  // a restitution of 1 then leaves all of the slip unknown
      tracks_[i].record.slip_uncertainty += fastest * bounces * flight / (1 - contact.restitution.value_or(0));
  }
}

double ContactHistory::get_slip_uncertainty(int contact) const {
  const ContactRecord& record = tracks_[static_cast<std::size_t>(contact)].record;
  const double slip = get_contact_totals(simulation_.plan(), simulation_.state(), contact).slip;
  return std::min(record.slip_uncertainty, slip);
}

ContactReading ContactHistory::calc(const State& state, int contact) const {
  return is_closed(state, static_cast<std::size_t>(contact)) ? readings_.get(state, contact) : ContactReading{};
}

double ContactHistory::calc(const State& state, int contact, Requirement::ContactValue value) const {
  using Value = Requirement::ContactValue;
  const auto get_totals = [&] { return get_contact_totals(simulation_.plan(), state, contact); };
  switch (value) {
    case Value::kForce:
      return calc(state, contact).normal;
    case Value::kDepth:
      return calc(state, contact).depth;
    case Value::kSlip:
      return get_totals().slip;
    case Value::kImpulse:
      return get_totals().impulse;
    case Value::kDissipated:
      return get_totals().dissipated;
  }
  return 0;
}

ContactReading ContactHistory::calc(const MotionWindow& window, int contact, double time) const {
  std::vector<Known>& known = known_[static_cast<std::size_t>(contact)];
  const auto found = std::ranges::find(known, time, &Known::time);
  if (found != known.end()) return found->reading;
  const State& state = (time < window.get_present().from ? previous_ : present_).state;
  for (std::size_t b = 0; b < state.bodies.size(); ++b)
    state.bodies[b] = window.calc_moving_body(static_cast<int>(b), time);
  known.push_back({time, calc_contact(simulation_.plan(), state, contact)});
  return known.back().reading;
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
  for (std::vector<Known>& known : known_) known.clear();
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    track.record.totals = get_contact_totals(simulation_.plan(), to.state, static_cast<int>(i));
    if (!is_closed(from.state, i)) continue;
    const int contact = static_cast<int>(i);
    const bool begins = track.fresh || !window.is_smooth();
    if (begins && !track.fresh) finish(track, contact);
    // Where the motion goes on smoothly, the piece begins with the force and the depth that the last one ended with.
    const bool known = !begins && !scenario_.model.contacts[i].rigid;
    const ContactReading at_to = calc(to.state, contact), at_from = known ? at_to : calc(from.state, contact);
    const double force = known ? track.force.get_latest() : -at_from.normal,
                 depth = known ? track.depth.get_latest() : -at_from.depth;
    track.force.add(from.time, force, to.time, -at_to.normal, begins,
                    [&](double time) { return -calc(window, contact, time).normal; });
    track.depth.add(from.time, depth, to.time, -at_to.depth, begins,
                    [&](double time) { return -calc(window, contact, time).depth; });
    if (track.kept) {
      if (begins && !track.fresh) {
        track.own_force.finish([&](double time) { return -calc(*window_, contact, time).normal; });
        track.own_depth.finish([&](double time) { return -calc(*window_, contact, time).depth; });
      }
      track.own_force.add(from.time, force, to.time, -at_to.normal, begins,
                          [&](double time) { return -calc(window, contact, time).normal; });
      track.own_depth.add(from.time, depth, to.time, -at_to.depth, begins,
                          [&](double time) { return -calc(window, contact, time).depth; });
      track.record.list.back().duration += to.time - from.time;
    }
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
    if (track.record.closed && track.kept) close_touch(track, static_cast<int>(i), track.record.list.back());
    records.push_back(track.record);
  }
  return records;
}

}  // namespace unlatch::hil
