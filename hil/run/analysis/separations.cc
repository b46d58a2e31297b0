#include "hil/run/analysis/separations.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/base/from_eigen.h"
#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

constexpr std::size_t kMost = 1000;  // separations: a joint that opens repeatedly would fill the memory

SplitRate split(const Vec3& w, const Vec3& axis) {
  const double axial = dot(w, axis);
  return {axial, norm(w - axial * axis)};
}

}  // namespace

SeparationMonitor::SeparationMonitor(const Scenario& scenario, bool pushes)
    : model_(place_markers(scenario.model)), pushes_(pushes) {
  for (int i = 0; i < model_.element_count(); ++i)
    if (auto spring = SpringWork::make(model_, i)) springs_.push_back(std::move(*spring));
}

void SeparationMonitor::add_events(const MotionKnot& before, const MotionKnot& after, ClearanceHistory& clearances) {
  bool changed = false;
  for (std::size_t i = 0; i < model_.joints.size(); ++i)
    changed = changed || before.state.joints[i].mode != after.state.joints[i].mode;
  if (changed) {
    const Assemblies was(model_, before.state), now(model_, after.state);
    const Assemblies rigid(model_, after.state, Holding::kRigid);
    for (Track& track : tracks_) {
      Separation& pair = track.separation;
      const int a = pair.base.body, b = pair.follower.body;
      if (track.over || !now.are_joined(a, b)) continue;
      if (pair.indirect && !are_connected(after.state, rigid, a, b)) continue;
      track.over = pair.rejoined = true;
      std::vector<int> joined = pair.indirect ? pair.base.bodies : now.list(a);
      if (pair.indirect) joined.insert(joined.end(), pair.follower.bodies.begin(), pair.follower.bodies.end());
      clearances.join(joined);
    }
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      const Joint& joint = model_.joints[i];
      if (before.state.joints[i].mode == after.state.joints[i].mode) continue;
      if (!was.are_joined(joint.base, joint.follower)) continue;
      if (!now.are_joined(joint.base, joint.follower))
        open(i, now, false, after, clearances);
      else if (get_rows(before.state, i) != 0 && !are_connected(after.state, rigid, joint.base, joint.follower))
        open(i, rigid, true, after, clearances);
    }
  }
  for (Track& track : tracks_) {
    if (track.over || before.time <= track.separation.release) continue;
    const bool ends = std::any_of(track.springs.begin(), track.springs.end(),
                                  [&](std::size_t i) { return springs_[i].acts(before) && !springs_[i].acts(after); });
    if (ends) set_end(track, before.time, before.state.bodies, before.state.auxiliary);
  }
}

RowSet SeparationMonitor::get_rows(const State& state, std::size_t joint) const {
  return model_.joints[joint].modes[static_cast<std::size_t>(state.joints[joint].mode)].rows;
}

bool SeparationMonitor::are_connected(const State& state, const Assemblies& rigid, int a, int b) const {
  if (rigid.are_joined(a, b)) return true;
  for (std::size_t i = 0; i < model_.joints.size(); ++i) {
    const Joint& joint = model_.joints[i];
    if (get_rows(state, i) == 0) continue;
    if (rigid.are_joined(joint.base, a) && rigid.are_joined(joint.follower, b)) return true;
    if (rigid.are_joined(joint.base, b) && rigid.are_joined(joint.follower, a)) return true;
  }
  return false;
}

void SeparationMonitor::open(std::size_t joint, const Assemblies& now, bool indirect, const MotionKnot& after,
                             ClearanceHistory& clearances) {
  const Joint& last = model_.joints[joint];
  for (Track& track : tracks_) {  // several joints between the same two open at this instant
    const Separation& other = track.separation;
    if (other.release != after.time || other.indirect != indirect || track.over) continue;
    if (now.are_joined(other.base.body, last.base) && now.are_joined(other.follower.body, last.follower)) return;
    if (now.are_joined(other.base.body, last.follower) && now.are_joined(other.follower.body, last.base)) return;
  }
  if (tracks_.size() == kMost) return;
  Track& track = tracks_.emplace_back();
  Separation& pair = track.separation;
  pair.joint = last.name;
  pair.indirect = indirect;
  pair.release = after.time;
  pair.base = {.body = last.base, .bodies = now.list(last.base), .rate = {}, .coning = {}};
  pair.follower = {.body = last.follower, .bodies = now.list(last.follower), .rate = {}, .coning = {}};
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    const int a = springs_[i].get_base(), b = springs_[i].get_follower();
    if ((contains(pair.base.bodies, a) && contains(pair.follower.bodies, b)) ||
        (contains(pair.base.bodies, b) && contains(pair.follower.bodies, a)))
      track.springs.push_back(i);
  }
  track.sums.resize(track.springs.size());
  set_end(track, after.time, after.state.bodies, after.state.auxiliary);
  clearances.release(after.time, pair.base.bodies, pair.follower.bodies);
}

void SeparationMonitor::set_end(Track& track, double time, std::span<const BodyState> bodies,
                                std::span<const double> burnt) {
  track.separation.end = time;
  track.bodies.assign(bodies.begin(), bodies.end());
  track.burnt.assign(burnt.begin(), burnt.end());
}

void SeparationMonitor::measure(const Track& track, Separation& pair) const {
  const auto get = [&](int body) { return body < 0 ? get_rest() : track.bodies[static_cast<std::size_t>(body)]; };
  const BodyState base = get(pair.base.body), follower = get(pair.follower.body);
  const Mat3 R_base = rotation_matrix(base.q), R_follower = rotation_matrix(follower.q);
  const AssemblyMotion motion_base = calc_motion(model_, pair.base.bodies, track.bodies, pair.end, track.burnt);
  const AssemblyMotion motion_follower = calc_motion(model_, pair.follower.bodies, track.bodies, pair.end, track.burnt);
  const Vec3 velocity = to_vec3(motion_follower.v - motion_base.v);
  const Vec3 parts = transpose_times(R_base, velocity);
  const double components[3] = {parts.x, parts.y, parts.z};
  const auto k = static_cast<int>(
      std::max_element(components, components + 3, [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      components);
  const bool negative = std::signbit(components[k]) && components[k] != 0;
  const Vec3 axis = (negative ? -1.0 : 1.0) * column(R_base, k);
  pair.axis = std::string(negative ? "-" : "+") + "xyz"[k] + " of " +
              (pair.base.body == kGround ? "the ground" : model_.bodies[static_cast<std::size_t>(pair.base.body)].name);
  pair.along = dot(velocity, axis);
  pair.across = norm(velocity - pair.along * axis);
  const Vec3 w_base = R_base * base.w, w_follower = R_follower * follower.w;
  pair.base.rate = split(w_base, axis);
  pair.follower.rate = split(w_follower, axis);
  pair.relative = split(w_follower - w_base, axis);
  pair.base.has_coning = motion_base.mass > 0;
  pair.follower.has_coning = motion_follower.mass > 0;
  pair.base.coning = calc_coning(motion_base);
  pair.follower.coning = calc_coning(motion_follower);
}

void SeparationMonitor::add_piece(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to) {
  for (Track& track : tracks_) {
    Separation& pair = track.separation;
    if (track.over || track.springs.empty()) continue;
    pair.pushes = false;
    std::optional<double> end;
    for (std::size_t i = 0; i < track.springs.size(); ++i) {
      const SpringWork& spring = springs_[track.springs[i]];
      if (spring.acts(to)) pair.pushes = true;
      if (!spring.acts(from) && !spring.acts(to)) continue;
      const auto ends = spring.find_end(window, from);
      if (ends) end = std::max(end.value_or(*ends), *ends);
      if (!pushes_) continue;
      const SpringWork::Sum sum = spring.calc(window, from, ends.value_or(to.time));
      track.sums[i].impulse += sum.impulse;
      track.sums[i].work += sum.work;
    }
    if (pair.pushes) end = to.time;  // known so far
    if (!end) continue;
    set_end(track, *end, to.state.bodies, to.state.auxiliary);
    if (*end == to.time) continue;
    for (std::size_t b = 0; b < track.bodies.size(); ++b) track.bodies[b] = window.calc_body(static_cast<int>(b), *end);
  }
}

std::vector<Separation> SeparationMonitor::list(const ClearanceHistory& clearances) const {
  std::vector<Separation> all;
  for (const Track& track : tracks_) {
    Separation& pair = all.emplace_back(track.separation);
    measure(track, pair);
    for (std::size_t i = 0; pushes_ && i < track.springs.size(); ++i)
      pair.pushers.push_back({model_.element_name(springs_[track.springs[i]].get_element()),
                              norm(track.sums[i].impulse), track.sums[i].work});
    const std::vector<Clearance>& watched = clearances.get();
    for (std::size_t i = 0; i < watched.size(); ++i) {
      const Clearance& c = watched[i];
      const bool between = (contains(pair.base.bodies, c.a) && contains(pair.follower.bodies, c.b)) ||
                           (contains(pair.base.bodies, c.b) && contains(pair.follower.bodies, c.a));
      if (!between || !c.after_release) continue;
      if (pair.pair < 0 ||
          c.after_release->smallest < watched[static_cast<std::size_t>(pair.pair)].after_release->smallest)
        pair.pair = static_cast<int>(i);
    }
  }
  return all;
}

}  // namespace unlatch::hil
