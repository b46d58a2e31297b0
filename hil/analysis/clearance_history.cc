#include "hil/analysis/clearance_history.h"

#include <algorithm>

namespace unlatch::hil {
namespace {

constexpr double kTie = 1e-6;        // m: a distance that changes less is told as one that does not change
constexpr double kRounding = 1e-13;  // of the size of a pair: shallower dips are rounding

bool has(const std::vector<int>& list, int body) { return std::find(list.begin(), list.end(), body) != list.end(); }

}  // namespace

ClearanceHistory::ClearanceHistory(const Scenario& scenario)
    : monitor_(scenario.clearance, scenario.shapes), now_(monitor_.get()), tracks_(now_.size()) {
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    tracks_[i].whole = tracks_[i].released = Smallest(get_resolution(static_cast<int>(i)));
}

double ClearanceHistory::get_resolution(int pair) const {
  return kRounding * monitor_.get_size(static_cast<std::size_t>(pair));
}

double ClearanceHistory::calc(const MotionWindow& window, int pair, double time) const {
  const Clearance& clearance = now_[static_cast<std::size_t>(pair)];
  return monitor_
      .calc(static_cast<std::size_t>(pair), to_placement(window.calc_body(clearance.a, time)),
            to_placement(window.calc_body(clearance.b, time)))
      .least.distance;
}

PairDistance ClearanceHistory::calc_witnesses(int pair) const {
  const Track& track = tracks_[static_cast<std::size_t>(pair)];
  return monitor_.calc(static_cast<std::size_t>(pair), track.at_a, track.at_b);
}

void ClearanceHistory::add_value(std::size_t pair, double time, double value) {
  Clearance& clearance = now_[pair];
  Track& track = tracks_[pair];
  clearance.now = value;
  clearance.smallest = track.whole.get_value();
  clearance.time = track.whole.get_time();
  if (track.whole.get_value() < track.tie - kTie) {
    track.tie = track.whole.get_value();
    clearance.tie = {.from = track.whole.get_time(), .to = track.whole.get_time(), .count = 1};
  }
  if (value <= track.tie + kTie && time > clearance.tie.to) {
    clearance.tie.to = time;
    ++clearance.tie.count;
  }
  if (track.after_release && track.released.has_value())
    clearance.after_release = {track.release_time, track.released.get_value(), track.released.get_time()};
}

void ClearanceHistory::begin(double time, std::span<const BodyState> bodies) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    Track& track = tracks_[i];
    track.at_a = to_placement(bodies[static_cast<std::size_t>(now_[i].a)]);
    track.at_b = to_placement(bodies[static_cast<std::size_t>(now_[i].b)]);
    const double value = monitor_.calc(i, track.at_a, track.at_b).least.distance;
    track.whole.add(time, value);
    track.tie = value;
    now_[i].tie = {.from = time, .to = time, .count = 1};
    if (value <= 0) now_[i].touch = time;
    add_value(i, time, value);
  }
}

void ClearanceHistory::keep_places(const MotionWindow& window, std::size_t pair) {
  Track& track = tracks_[pair];
  track.at_a = to_placement(window.calc_body(now_[pair].a, track.whole.get_time()));
  track.at_b = to_placement(window.calc_body(now_[pair].b, track.whole.get_time()));
}

// The first zero, by bisection: between the knots, or before the bottom of a dip between them.
void ClearanceHistory::find_touch(const MotionWindow& window, std::size_t pair, double before, double value,
                                  const Smallest::Function& function) {
  constexpr int kHalvings = 40;
  const Smallest& whole = tracks_[pair].whole;
  if (now_[pair].touch || !(whole.get_value() <= 0)) return;
  double from = window.get_present().from, to = window.get_present().to;
  if (!(value <= 0) || before <= 0) {
    to = whole.get_time();
    if (to <= from) from = window.get_previous().from;
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (from + to);
    (function(middle) <= 0 ? to : from) = middle;
  }
  now_[pair].touch = to;
}

void ClearanceHistory::add(const MotionWindow& window) {
  const MotionPiece& piece = window.get_present();
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const int pair = static_cast<int>(i);
    const auto function = [&](double time) { return calc(window, pair, time); };
    const double before = now_[i].now, value = function(piece.to);
    Track& track = tracks_[i];
    const double smallest_time = track.whole.get_time();
    for (Smallest* smallest : {&track.whole, track.after_release ? &track.released : nullptr}) {
      if (smallest == nullptr) continue;
      if (!window.is_smooth()) smallest->finish(function);
      smallest->add(piece.from, before, piece.to, value, !window.is_smooth(), function);
    }
    if (track.whole.get_time() != smallest_time) keep_places(window, i);
    find_touch(window, i, before, value, function);
    if (piece.to > piece.from) now_[i].rate = (value - before) / (piece.to - piece.from);
    add_value(i, piece.to, value);
  }
}

void ClearanceHistory::release(double time, const std::vector<int>& a, const std::vector<int>& b) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const Clearance& pair = now_[i];
    if (!((has(a, pair.a) && has(b, pair.b)) || (has(a, pair.b) && has(b, pair.a)))) continue;
    tracks_[i].after_release = true;
    tracks_[i].release_time = time;
    tracks_[i].released = Smallest(get_resolution(static_cast<int>(i)));
    tracks_[i].released.add(time, pair.now);
    now_[i].after_release = {time, pair.now, time};
  }
}

void ClearanceHistory::join(const std::vector<int>& bodies) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    if (!has(bodies, now_[i].a) || !has(bodies, now_[i].b)) continue;
    tracks_[i].after_release = false;
    now_[i].after_release.reset();
  }
}

}  // namespace unlatch::hil
