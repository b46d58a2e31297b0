#include "hil/run/analysis/spring_work.h"

#include <algorithm>

#include "hil/scenario/base/index.h"
#include "unlatch/readings.h"

namespace unlatch::hil {

std::optional<SpringWork> SpringWork::make(const Model& model, int element) {
  SpringWork work;
  work.element_ = element;
  const std::size_t loads = model.loads.size(), points = model.point_springs.size();
  const auto i = static_cast<std::size_t>(element);
  if (i >= loads && i < loads + points) {
    work.point_ = model.point_springs[i - loads];
    work.base_ = work.point_->base;
    work.follower_ = work.point_->follower;
    return work;
  }
  const std::size_t joints = model.joint_springs.size();
  const std::size_t first = at(get_first_one_sided(model));
  if (i >= first && i < first + model.one_sided.size()) {
    work.number_ = i - first;
    work.one_sided_ = model.one_sided[work.number_];
    const OneSided& force = *work.one_sided_;
    work.limit_ = calc_limit(model, force);
    if (force.joint != kNone) work.geometry_.emplace(model, force.joint);
    if (force.drum) {
      work.drum_ = place_drum(model, force);
      work.drum_number_ = static_cast<std::size_t>(
          std::count_if(model.one_sided.begin(), model.one_sided.begin() + static_cast<std::ptrdiff_t>(work.number_),
                        [](const OneSided& f) { return f.drum.has_value(); }));
    }
    work.base_ = work.geometry_ ? work.geometry_->get_base() : force.base;
    work.follower_ = work.geometry_ ? work.geometry_->get_follower() : force.follower;
    return work;
  }
  if (i < loads + points || i >= loads + points + joints) return {};
  work.joint_ = model.joint_springs[i - loads - points];
  work.geometry_.emplace(model, work.joint_->joint);
  work.base_ = work.geometry_->get_base();
  work.follower_ = work.geometry_->get_follower();
  return work;
}

double SpringWork::calc_length(const BodyState& base, const BodyState& follower) const {
  return calc_point_spring(*point_, base, follower, 0).length;
}

bool SpringWork::acts(const MotionKnot& knot) const {
  if (calc_scale(knot.state.elements[static_cast<std::size_t>(element_)], knot.time) == 0) return false;
  if (one_sided_) return knot.state.engaged[number_] != 0;
  if (!point_ || !point_->push_only) return true;
  const auto body = [&](int i) { return i < 0 ? get_rest() : knot.state.bodies[static_cast<std::size_t>(i)]; };
  return calc_length(body(base_), body(follower_)) < point_->free_length;
}

std::optional<double> SpringWork::find_end(const MotionWindow& window, const MotionKnot& from) const {
  if (!point_ || !point_->push_only || !acts(from)) return {};
  const auto is_beyond = [&](double time) {
    return calc_length(window.calc_body(base_, time), window.calc_body(follower_, time)) >= point_->free_length;
  };
  const MotionPiece& piece = window.get_present();
  double low = piece.from, high = piece.to;
  if (!is_beyond(high)) return {};
  for (const double stop = 1e-9 * (high - low); high - low > stop;) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    (is_beyond(middle) ? high : low) = middle;
  }
  return high;
}

SpringWork::Force SpringWork::calc_force(const BodyState& base, const BodyState& follower, double scale,
                                         double bearing) const {
  if (one_sided_) return calc_one_sided(base, follower, scale, bearing);
  if (joint_) {
    const double x = geometry_->calc_coordinate(base, follower, joint_->axis);
    const double rate = geometry_->calc_speed(base, follower, joint_->axis);
    const double size = calc_joint_spring(*joint_, x, rate, scale);
    return {size * geometry_->calc_axis(base, joint_->axis), size * rate};
  }
  const PointSpringForce f = calc_point_spring(*point_, base, follower, scale);
  return {f.size * f.direction, f.size * f.rate};
}

SpringWork::Force SpringWork::calc_one_sided(const BodyState& base, const BodyState& follower, double scale,
                                             double bearing) const {
  if (!geometry_) {
    const OneSidedForce f =
        calc_one_sided_force(*one_sided_, limit_, drum_ ? &*drum_ : nullptr, bearing, base, follower);
    return {scale * f.size * f.direction, scale * f.size * f.rate};
  }
  const double x = geometry_->calc_coordinate(base, follower, one_sided_->axis);
  const double rate = geometry_->calc_speed(base, follower, one_sided_->axis);
  const double sign = one_sided_->pulls ? -1 : 1;
  const double size = sign * scale * calc_one_sided_force(*one_sided_, sign * (limit_ - x), -sign * rate);
  return {size * geometry_->calc_axis(base, one_sided_->axis), size * rate};
}

SpringWork::Sum SpringWork::calc(const MotionWindow& window, const MotionKnot& from, double to) const {
  const double h = to - from.time;
  Sum sum;
  if (!(h > 0)) return sum;
  if (one_sided_ && from.state.engaged[number_] == 0) return sum;
  const ElementState& element = from.state.elements[static_cast<std::size_t>(element_)];
  const double bearing = drum_ ? from.state.bearings[drum_number_] : 0;
  for (const int i : {0, 1, 2}) {
    const double time = i == 2 ? to : from.time + 0.5 * i * h, weight = (i == 1 ? 4 : 1) * h / 6;
    const double scale = calc_scale(element, time);
    if (scale == 0) continue;
    const Force force = calc_force(window.calc_body(base_, time), window.calc_body(follower_, time), scale, bearing);
    sum.impulse += weight * force.force;
    sum.work += weight * force.power;
  }
  return sum;
}

}  // namespace unlatch::hil
