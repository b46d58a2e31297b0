#include "hil/run/motion/clearance_history.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

constexpr double kTie = 1e-6;  // m: a distance that changes less is reported as constant
// Relative to the size of a pair: motions of rigidly joined bodies, which change the distance by no more than its
// error.
constexpr double kStill = 1e-10;
// Of Track::parted: planes have shown a piece to be skipped, which was computed nevertheless.
constexpr int kCleared = -1;

}  // namespace

ClearanceHistory::ClearanceHistory(const Scenario& scenario, Skipping skipping)
    : skipping_(skipping),
      monitor_(scenario.clearance, scenario.shapes, scenario.ground_shapes),
      now_(monitor_.get()),
      tracks_(now_.size()) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].size = monitor_.get_size(i);
    tracks_[i].whole = tracks_[i].released = Smallest(get_resolution(static_cast<int>(i)));
  }
  const std::size_t bodies = scenario.model.bodies.size();
  const auto get_body = [&](int body) { return body == kGround ? bodies : static_cast<std::size_t>(body); };
  for (std::size_t i = 0; i < now_.size(); ++i)
    dips_.emplace_back(monitor_, i, get_body(now_[i].a), get_body(now_[i].b), skipping);
  places_.resize(scenario.model.bodies.size() + 1);  // the ground is the last
  bodies_.resize(scenario.model.bodies.size() + 1);
  for (const Clearance& pair : now_)
    for (const int body : {pair.a, pair.b})
      if (!contains(watched_, body)) watched_.push_back(body);
}

const std::vector<Clearance>& ClearanceHistory::get() const {
  for (std::size_t i = 0; i < now_.size(); ++i) refresh_rate(i);
  return now_;
}

void ClearanceHistory::refresh(std::size_t pair) const {
  if (!tracks_[pair].stale) return;
  tracks_[pair].stale = false;
  tracks_[pair].rateless = true;
  now_[pair].now = calc(*window_, static_cast<int>(pair), window_->get_present().to);
}

void ClearanceHistory::refresh_rate(std::size_t pair) const {
  refresh(pair);
  if (!tracks_[pair].rateless) return;
  tracks_[pair].rateless = false;
  const MotionPiece& piece = window_->get_present();
  const double before = calc(*window_, static_cast<int>(pair), piece.from);
  if (piece.to > piece.from) now_[pair].rate = (now_[pair].now - before) / (piece.to - piece.from);
}

RelativeMotion ClearanceHistory::calc_relative(std::size_t pair, const MovingBody& a, const MovingBody& b) const {
  return calc_relative_motion(monitor_.get_reach(pair), a, b);
}

// Bound on a distance's change.
double ClearanceHistory::calc_change(std::size_t pair, const RelativeMotion& from, const RelativeMotion& to) const {
  return geometry::calc_way(from.centre, from.R, to.centre, to.R, monitor_.get_reach(pair).bound);
}

// The greater of the smallest values so far: a result changes only below it.
double ClearanceHistory::get_smallest(std::size_t pair) const {
  const Track& track = tracks_[pair];
  return track.after_release ? std::max(track.whole.get_value(), track.released.get_value()) : track.whole.get_value();
}

// Distance below which a result may change: a new smallest value, or a tie with it.
double ClearanceHistory::get_limit(std::size_t pair) const { return kTie + get_smallest(pair); }

// No distance within the piece is below this, m: a bound that is cheaper than that of skip(), and wider, by paths of
// the origins and sums of rotation angles. Inside the piece the interpolated motion departs from its end by less than
// twice the greater speed times the step.
double ClearanceHistory::calc_far(const MotionPiece& piece, std::size_t pair) const {
  const Track& track = tracks_[pair];
  const ClearanceMonitor::Reach& reach = monitor_.get_reach(pair);
  const auto a = get_index(now_[pair].a), b = get_index(now_[pair].b);
  const double h = piece.to - piece.from;
  const double speed = std::max(norm(piece.start[b].v - piece.start[a].v), norm(piece.end[b].v - piece.end[a].v));
  const double increase =
      std::max(norm(piece.at_start[b].lin - piece.at_start[a].lin), norm(piece.at_end[b].lin - piece.at_end[a].lin));
  const double way = norm((piece.end[b].p - piece.end[a].p) - track.between) + (2 * speed * h + increase * (h * h));
  const double turned_a = bodies_[a].turned - track.turned_a, turned_b = bodies_[b].turned - track.turned_b;
  const double size = norm(reach.centre) + reach.bound;
  const double from = reach.of_b ? turned_a : turned_b;  // rotates the whole distance between the two
  const double most = way + (turned_a + turned_b) * size + from * (norm(track.between) + way);
  return track.value - most;
}

const MovingBody& ClearanceHistory::get_end(const MotionPiece& piece, std::size_t body) {
  if (!bodies_[body].fresh) places_[body] = get_moving_body(piece.end[body], piece.at_end[body]);
  bodies_[body].fresh = true;
  return places_[body];
}

// Notes that the distance has been computed at the end of the piece.
void ClearanceHistory::set_reference(const MotionPiece& piece, std::size_t pair, double value) {
  Track& track = tracks_[pair];
  const auto a = get_index(now_[pair].a), b = get_index(now_[pair].b);
  track.reference = track.latest;
  track.between = piece.end[b].p - piece.end[a].p;
  track.turned_a = bodies_[a].turned;
  track.turned_b = bodies_[b].turned;
  track.value = value;
  track.moved = 0;
}

bool ClearanceHistory::stays_above(int pair, double limit) const {
  const auto i = static_cast<std::size_t>(pair);
  const Track& track = tracks_[i];
  if (track.still) return false;  // the distance is that of the latest knot, which costs nothing
  if (track.least - kStill * track.size >= limit) return true;  // beyond rounding
  return dips_[i].stays_above(monitor_, window_->get_present(), limit);
}

// Returns true if the pair cannot become smaller in the present piece than before, or does not move.
bool ClearanceHistory::skip(const MotionWindow& window, std::size_t pair) {
  const MotionPiece& piece = window.get_present();
  Track& track = tracks_[pair];
  constexpr double kEver = std::numeric_limits<double>::infinity();
  track.length = kEver;
  track.least = -kEver;
  track.still = false;
  if (!std::isfinite(monitor_.get_reach(pair).bound)) return false;
  const bool still = track.idle && !track.stale;  // in the piece before: there the wide bound has no margin
  const double far = skipping_ == Skipping::kOn && !still ? calc_far(piece, pair) : -kEver;
  if (far > get_limit(pair)) {
    track.least = far;
    track.parted = 0;
    track.followed = false;
    track.stale = true;
    return true;
  }
  const auto a = get_index(now_[pair].a), b = get_index(now_[pair].b);
  const double h = piece.to - piece.from;
  if (!window.is_smooth() || !track.followed) {
    track.latest = calc_relative(pair, get_moving_body(piece.start[a], piece.at_start[a]),
                                 get_moving_body(piece.start[b], piece.at_start[b]));
    track.moved = calc_change(pair, track.reference, track.latest);
  }
  const RelativeMotion before = track.latest;
  const double moved_before = track.moved;
  track.latest = calc_relative(pair, get_end(piece, a), get_end(piece, b));
  track.followed = true;
  track.moved = calc_change(pair, track.reference, track.latest);
  track.length = calc_length(before, track.latest, h);
  const double most = std::max(moved_before, track.moved) + calc_path(before, track.latest, h);
  if (most <= kStill * track.size) {
    now_[pair].now = track.value;
    now_[pair].rate = 0;
    track.still = true;
    track.parted = 0;
    track.stale = track.rateless = false;
    if (track.value <= track.tie + kTie && piece.to > now_[pair].tie.to) {
      now_[pair].tie.to = piece.to;
      ++now_[pair].tie.count;
    }
    return true;
  }
  if (skipping_ == Skipping::kOff) return false;
  track.least = track.value - most;
  const double room = track.value - get_limit(pair);
  const bool near = !(room > most);
  const bool above = near && dips_[pair].stays_above(monitor_, piece, get_limit(pair));
  // The first such piece is computed: then the searches about its ends are the same as without skipping.
  const bool first = above && !track.idle && track.parted != kCleared;
  if (first) track.parted = kCleared;
  if (near && !above && track.parted == kCleared) track.parted = 0;
  if (first || (near && !above)) return false;
  track.stale = true;
  // From a new reference the wide bound is useful again; while shapes slide along each other, only now and then.
  constexpr double kUsed = 0.25;
  constexpr int kLongest = 64;
  track.parted = near ? std::max(track.parted, 0) + 1 : 0;
  if (track.parted > 0 && track.parted <= track.wait) return true;
  track.wait = near ? std::min(2 * track.wait, kLongest) : 1;
  if (track.moved > kUsed * room) set_reference(piece, pair, calc(window, static_cast<int>(pair), piece.to));
  track.parted = near ? 1 : 0;
  return true;
}

double ClearanceHistory::get_resolution(int pair) const {
  return monitor_.get_resolution(static_cast<std::size_t>(pair));
}

double ClearanceHistory::get_error(int pair) const {
  return kDistanceError * monitor_.get_size(static_cast<std::size_t>(pair));
}

double ClearanceHistory::calc(const MotionWindow& window, int pair, double time) const {
  if (const auto known = dips_[static_cast<std::size_t>(pair)].calc_within(monitor_, window, time)) return *known;
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
  publish(pair);
  if (track.whole.get_value() < track.tie - kTie) {
    track.tie = track.whole.get_value();
    clearance.tie = {.from = track.whole.get_time(), .to = track.whole.get_time(), .count = 1};
  }
  if (value <= track.tie + kTie && time > clearance.tie.to) {
    clearance.tie.to = time;
    ++clearance.tie.count;
  }
}

void ClearanceHistory::publish(std::size_t pair) {
  Clearance& clearance = now_[pair];
  const Track& track = tracks_[pair];
  clearance.smallest = track.whole.get_value();
  clearance.time = track.whole.get_time();
  if (track.after_release && track.released.has_value())
    clearance.after_release = {track.release_time, track.released.get_value(), track.released.get_time()};
}

void ClearanceHistory::begin(double time, std::span<const BodyState> bodies) {
  const auto get = [&](int body) { return body == kGround ? get_rest() : bodies[static_cast<std::size_t>(body)]; };
  for (std::size_t i = 0; i < now_.size(); ++i) {
    Track& track = tracks_[i];
    const BodyState at_a = get(now_[i].a), at_b = get(now_[i].b);
    track.at_a = to_placement(at_a);
    track.at_b = to_placement(at_b);
    const double value = monitor_.calc(i, track.at_a, track.at_b).least.distance;
    track.whole.add(time, value);
    track.value = value;
    track.moved = 0;
    track.idle = track.stale = track.rateless = false;
    const auto a = get_index(now_[i].a), b = get_index(now_[i].b);
    track.between = at_b.p - at_a.p;
    track.turned_a = bodies_[a].turned;
    track.turned_b = bodies_[b].turned;
    const Spatial none{{0, 0, 0}, {0, 0, 0}};
    track.reference = calc_relative(i, get_moving_body(at_a, none), get_moving_body(at_b, none));
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

// Bound on the speed at which the distance changes within a piece, m/s.
double ClearanceHistory::calc_fastest(const MotionPiece& piece, std::size_t pair) const {
  const auto a = get_index(now_[pair].a), b = get_index(now_[pair].b);
  const auto get = [&](std::span<const BodyState> bodies, std::span<const Spatial> accelerations) {
    return calc_relative(pair, get_moving_body(bodies[a], accelerations[a]),
                         get_moving_body(bodies[b], accelerations[b]));
  };
  const double h = piece.to - piece.from;
  return calc_path(get(piece.start, piece.at_start), get(piece.end, piece.at_end), h) / h;
}

namespace {

// Where a distance that is above 0 at `from` gets to 0, between the two (Illinois; M. Dowell, P. Jarratt, 1971).
double find_zero(double from, double at_from, double to, double at_to, double tolerance, const TimeFunction& function) {
  constexpr int kMost = 60;
  int side = 0;  // of the end that was replaced last
  for (int i = 0; i < kMost && to - from > tolerance && at_to < 0; ++i) {
    const double secant = to - at_to * ((to - from) / (at_to - at_from));
    const double time = secant > from && secant < to ? secant : 0.5 * (from + to);
    const double value = function(time);
    if (value > 0) {
      from = time;
      at_from = value;
      if (side == -1) at_to *= 0.5;
      side = -1;
    } else {
      to = time;
      at_to = value;
      if (side == 1) at_from *= 0.5;
      side = 1;
    }
  }
  return to;
}

}  // namespace

// First zero in a piece: between its ends, or before the bottom of a dip between them. A distance may be positive again
// behind a zero (a mesh has no inside), so that no bracket finds the first: from the beginning of the piece the time
// advances by what the distance cannot use up (conservative advancement). Shapes that slide along each other approach
// far more slowly than they move; where distances have a sign, the rest is searched between the two.
void ClearanceHistory::find_touch(const MotionWindow& window, std::size_t pair, bool crosses,
                                  const TimeFunction& function) {
  constexpr int kMostLooks = 400;  // of a distance that changes ten times as slowly as it may, to rounding
  constexpr int kSignedLooks = 24;
  constexpr double kTouch = 1e-12;  // of the piece's length: times nearer than this are one
  const Smallest& whole = tracks_[pair].whole;
  if (now_[pair].touch || !(whole.get_value() <= 0)) return;
  const bool is_before = !crosses && whole.get_time() <= window.get_present().from;
  const MotionPiece& piece = is_before ? window.get_previous() : window.get_present();
  const double end = crosses ? piece.to : whole.get_time(), fastest = calc_fastest(piece, pair);
  const bool has_sign = now_[pair].method == DistanceMethod::kExact;
  double time = piece.from, distance = function(time);
  bool found = !(distance > 0);
  for (int i = 0; i < (has_sign ? kSignedLooks : kMostLooks) && !found; ++i) {
    const double advance = distance / fastest;
    found = !(advance > kTouch * (piece.to - piece.from));
    if (found) break;
    time += advance;
    found = !(time < end);
    if (found) break;
    distance = function(time);
    found = !(distance > 0);
  }
  if (!found && has_sign)
    time = find_zero(time, distance, end, function(end), kTouch * (piece.to - piece.from), function);
  now_[pair].touch = std::min(time, end);
}

void ClearanceHistory::add(const MotionWindow& window) {
  const MotionPiece& piece = window.get_present();
  window_ = &window;
  const double h = piece.to - piece.from;
  for (const int body : watched_) {
    const std::size_t b = get_index(body);
    const double speed = std::max(norm(piece.start[b].w), norm(piece.end[b].w));
    const double increase = std::max(norm(piece.at_start[b].ang), norm(piece.at_end[b].ang));
    bodies_[b] = {.turned = bodies_[b].turned + (2 * speed * h + increase * (h * h)), .fresh = false};
  }
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const int pair = static_cast<int>(i);
    const auto function = [&](double time) { return calc(window, pair, time); };
    Track& track = tracks_[i];
    const double smallest_time = track.whole.get_time();
    const bool skips = skip(window, i), ends = !track.idle && (skips || !window.is_smooth());
    if (skips && track.idle) continue;
    if (ends) {
      track.whole.finish(function);
      if (track.after_release) track.released.finish(function);
    }
    if (skips) {
      track.idle = true;
      if (track.whole.get_time() != smallest_time) keep_places(window, i);
      find_touch(window, i, false, function);
      publish(i);
      continue;
    }
    const double before = track.idle ? function(piece.from) : now_[i].now;
    const std::optional<double> end = dips_[i].calc_end(monitor_, piece);
    const double value = end ? *end : function(piece.to);
    // Behind a piece that only just could be skipped, the search goes on as if it had not been.
    const bool resumes = track.idle && track.parted > 0 && window.is_smooth();
    const bool resumes_released = resumes && track.after_release && track.release_time <= window.get_previous().from;
    const bool begins = track.idle || !window.is_smooth();
    if (resumes) {
      const MotionPiece& latest = window.get_previous();
      const double first = function(latest.from);
      track.whole.add(latest.from, first, latest.to, before, true, function);
      if (resumes_released) track.released.add(latest.from, first, latest.to, before, true, function);
    }
    if (track.parted != kCleared) track.parted = 0;
    track.idle = track.stale = track.rateless = false;
    set_reference(piece, i, value);
    track.whole.add(piece.from, before, piece.to, value, begins && !resumes, function);
    if (track.after_release)
      track.released.add(piece.from, before, piece.to, value, begins && !resumes_released, function);
    look_between_knots(piece, i, before, value);
    if (track.whole.get_time() != smallest_time) keep_places(window, i);
    find_touch(window, i, before > 0 && value <= 0, function);
    if (piece.to > piece.from) now_[i].rate = (value - before) / (piece.to - piece.from);
    add_value(i, piece.to, value);
  }
}

// Looks for pairs of shapes that are nearest inside the piece, and at neither end of it.
void ClearanceHistory::look_between_knots(const MotionPiece& piece, std::size_t pair, double before, double value) {
  Track& track = tracks_[pair];
  const std::optional<Dip> dip = dips_[pair].find(monitor_, piece,
                                                  {.length = track.length,
                                                   .limit = get_smallest(pair),
                                                   .resolution = get_resolution(static_cast<int>(pair)),
                                                   .at_from = before,
                                                   .at_to = value});
  if (!dip) return;
  track.whole.take(dip->time, dip->value);
  if (track.after_release) track.released.take(dip->time, dip->value);
}

void ClearanceHistory::release(double time, const std::vector<int>& a, const std::vector<int>& b) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const Clearance& pair = now_[i];
    if (!((contains(a, pair.a) && contains(b, pair.b)) || (contains(a, pair.b) && contains(b, pair.a)))) continue;
    if (tracks_[i].after_release) continue;  // they parted earlier, while still joined through others
    refresh(i);
    tracks_[i].after_release = true;
    tracks_[i].release_time = time;
    tracks_[i].released = Smallest(get_resolution(static_cast<int>(i)));
    tracks_[i].released.add(time, pair.now);
    now_[i].after_release = {time, pair.now, time};
  }
}

void ClearanceHistory::join(const std::vector<int>& bodies) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    if (!contains(bodies, now_[i].a) || !contains(bodies, now_[i].b)) continue;
    tracks_[i].after_release = false;
    now_[i].after_release.reset();
  }
}

}  // namespace unlatch::hil
