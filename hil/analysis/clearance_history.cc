#include "hil/analysis/clearance_history.h"

#include <algorithm>

namespace unlatch::hil {
namespace {

constexpr double kTie = 1e-6;  // m: what a convex distance resolves

Pose to_pose(const BodyState& body) {
  return {{body.p.x, body.p.y, body.p.z}, {body.q.w, body.q.x, body.q.y, body.q.z}};
}

bool has(const std::vector<int>& list, int body) { return std::find(list.begin(), list.end(), body) != list.end(); }

}  // namespace

ClearanceHistory::ClearanceHistory(const Scenario& scenario)
    : monitor_(scenario.clearance, scenario.shapes), now_(monitor_.get()), tracks_(now_.size()) {
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    tracks_[i].whole = tracks_[i].released = Smallest(get_resolution(static_cast<int>(i)));
}

double ClearanceHistory::get_resolution(int pair) const {
  return monitor_.is_exact(static_cast<std::size_t>(pair)) ? 0 : kTie;
}

int ClearanceHistory::find(int a, int b) const {
  for (std::size_t i = 0; i < now_.size(); ++i)
    if ((now_[i].a == a && now_[i].b == b) || (now_[i].a == b && now_[i].b == a)) return static_cast<int>(i);
  return -1;
}

double ClearanceHistory::calc(const MotionWindow& window, int pair, double time) const {
  const Clearance& clearance = now_[static_cast<std::size_t>(pair)];
  return monitor_.calc(static_cast<std::size_t>(pair), to_pose(window.calc_body(clearance.a, time)),
                       to_pose(window.calc_body(clearance.b, time)));
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
    const double value = monitor_.calc(i, to_pose(bodies[static_cast<std::size_t>(now_[i].a)]),
                                       to_pose(bodies[static_cast<std::size_t>(now_[i].b)]));
    Track& track = tracks_[i];
    track.whole.add(time, value);
    track.tie = value;
    now_[i].tie = {.from = time, .to = time, .count = 1};
    add_value(i, time, value);
  }
}

void ClearanceHistory::add(const MotionWindow& window) {
  const MotionPiece& piece = window.get_present();
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const int pair = static_cast<int>(i);
    const auto function = [&](double time) { return calc(window, pair, time); };
    const double before = now_[i].now, value = function(piece.to);
    Track& track = tracks_[i];
    for (Smallest* smallest : {&track.whole, track.after_release ? &track.released : nullptr}) {
      if (smallest == nullptr) continue;
      if (!window.is_smooth()) smallest->finish(function);
      smallest->add(piece.from, before, piece.to, value, !window.is_smooth(), function);
    }
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
