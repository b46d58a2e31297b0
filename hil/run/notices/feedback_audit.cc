#include "hil/run/notices/feedback_audit.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "hil/run/audit/dependence.h"
#include "hil/run/notices/resolution.h"
#include "hil/scenario/base/index.h"
#include "unlatch/contacts.h"
#include "unlatch/readings.h"

namespace unlatch::hil {
namespace {

constexpr double kLeast = 1e-9;      // m/s, rad/s: errors of a step that do not count
constexpr double kLeastPart = 1e-7;  // likewise, of the largest change of a velocity
constexpr double kSmall = 1e-3;      // of what was flown between two knots: the width of a difference
constexpr double kFar = 1e-7;        // of a place: it is not known better than that for a difference
constexpr double kTallest = 120;     // 5!
constexpr double kWhole = 0.999;     // of a step: less is a part of it
constexpr int kPowers = 4;           // of the derivative

Quat turn(const Quat& q, const Vec3& by) {  // world axes, rad
  return normalized(Quat{1, 0.5 * by.x, 0.5 * by.y, 0.5 * by.z} * q);
}
Vec3 calc_turn(const Quat& from, const Quat& to) {  // world axes, rad, for small turns
  const Quat d = to * conjugate(from);
  return (d.w < 0 ? -2.0 : 2.0) * Vec3{d.x, d.y, d.z};
}
Quat find_middle(const Quat& a, const Quat& b) {
  const double sign = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -1 : 1;
  return normalized(Quat{a.w + sign * b.w, a.x + sign * b.x, a.y + sign * b.y, a.z + sign * b.z});
}

// Whether an acceleration changed by more than a slow feedback could have made it change, on any axis.
bool is_quick(const Vec3& change, const Vec3& velocity, const Vec3& place, double time, double least) {
  const auto is_quick_along = [&](double a, double v, double x) {
    const double by = std::abs(a) * time;
    return by > least &&
           (by > kUnresolvedSize * std::abs(v) || by * time > kUnresolvedSize * kUnresolvedSize * std::abs(x));
  };
  return is_quick_along(change.x, velocity.x, place.x) || is_quick_along(change.y, velocity.y, place.y) ||
         is_quick_along(change.z, velocity.z, place.z);
}

// Errors relative to the centre of mass of all bodies: of several bodies at most, since their directions are not known.
void set_own(const Model& model, std::span<FeedbackError> errors) {
  constexpr MotionPart kParts[][2] = {{MotionPart::kPlace, MotionPart::kOwnPlace},
                                      {MotionPart::kVelocity, MotionPart::kOwnVelocity}};
  double all = 0;
  for (const Body& body : model.bodies) all += body.marker ? 0 : body.mass;
  for (const auto& [whole, own] : kParts) {
    const auto get = [part = at(static_cast<int>(whole))](const FeedbackError& error) { return error.error[part]; };
    double common = 0;
    for (const FeedbackError& error : errors) common += model.bodies[at(error.body)].mass / all * get(error);
    for (FeedbackError& error : errors) {
      const double part = model.bodies[at(error.body)].mass / all;
      error.error[at(static_cast<int>(own))] = std::min(get(error), (1 - 2 * part) * get(error) + common);
    }
  }
}

double get_size(const Spatial& change, bool turns) { return norm(turns ? change.ang : change.lin); }

}  // namespace

FeedbackAudit::FeedbackAudit(const Simulation& simulation)
    : simulation_(simulation),
      courses_(simulation.model().bodies.size()),
      changes_(courses_.size()),
      accelerations_(courses_.size()),
      modal_(courses_.size()),
      left_out_(courses_.size()),
      block_(simulation.plan().get_state_bytes() / sizeof(std::uint64_t)),
      middle_block_(block_.size()),
      state_(simulation.plan(), std::as_writable_bytes(std::span(block_))),
      middle_(simulation.plan(), std::as_writable_bytes(std::span(middle_block_))) {
  const double dt = simulation.plan().get_options().dt;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const Body& body = simulation.model().bodies[b];
    modal_[b] = body.flexible && body.flexible->frequencies.size() > 0 &&
                dt * body.flexible->frequencies.maxCoeff() > kResolved;
  }
}

void FeedbackAudit::set_rates(std::span<const ElementFrequency> frequencies) {
  implicit_.clear();
  for (const ElementFrequency& own : frequencies)
    if (own.implicit) implicit_.push_back(own.element);
}

std::span<const FeedbackError> FeedbackAudit::update(Workspace& workspace) {
  errors_.clear();
  ++ticks_;
  const std::span<const MotionKnot> knots = simulation_.get_motion();
  if (ticks_ == 1 && !knots.empty())
    for (std::size_t b = 0; b < courses_.size(); ++b) {
      courses_[b].v = knots.front().state.bodies[b].v;
      courses_[b].w = knots.front().state.bodies[b].w;
    }
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (knots[i].begins || !suspect(knots[i - 1], knots[i])) continue;
    if (looks_ >= kFirst + ticks_ / kEvery) break;
    ++looks_;
    measure(knots[i - 1], knots[i], workspace);
  }
  set_own(simulation_.model(), errors_);
  return errors_;
}

// Whether a feedback may have acted within a piece of motion that the step does not resolve.
bool FeedbackAudit::suspect(const MotionKnot& from, const MotionKnot& to) {
  const double time = to.time - from.time;
  bool any = false;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    Course& course = courses_[b];
    const BodyState &begin = from.state.bodies[b], &end = to.state.bodies[b];
    course.most_v = std::max(course.most_v, norm(end.v - course.v));
    course.most_w = std::max(course.most_w, norm(end.w - course.w));
    course.suspect = false;
    if (simulation_.model().bodies[b].marker || !(time > 0)) continue;
    const Spatial &first = from.accelerations[b], &last = to.accelerations[b];
    course.moved = {end.p - begin.p, calc_turn(begin.q, end.q)};
    course.by = {end.v - begin.v, rotation_matrix(end.q) * end.w - rotation_matrix(begin.q) * begin.w};
    course.suspect = is_quick(last.lin - first.lin, course.by.lin, course.moved.lin, time,
                              std::max(kLeast, kLeastPart * course.most_v)) ||
                     is_quick(last.ang - first.ang, course.by.ang, course.moved.ang, time,
                              std::max(kLeast, kLeastPart * course.most_w));
    any = any || course.suspect;
  }
  return any;
}

// Bodies whose steps have other errors, and those that joints connect to them.
void FeedbackAudit::list_left_out() {
  const Model& model = simulation_.model();
  left_out_ = modal_;
  const auto leave_out = [this](const std::vector<int>& bodies) {
    for (const int body : bodies) left_out_[at(body)] = true;
  };
  for (const int element : implicit_) {
    const ElementState& state = middle_.elements[at(element)];
    if (state.from != 0 || state.to != 0) leave_out(list_element_bodies(model, element));
  }
  for (std::size_t i = 0; i < model.contacts.size(); ++i) {
    const auto pairs = get_contact_pairs(simulation_.plan(), middle_, static_cast<int>(i));
    if (std::ranges::any_of(pairs, [](const ContactState& pair) { return pair.closed != 0; }))
      leave_out(list_contact_bodies(model, static_cast<int>(i)));
  }
  for (bool spreads = true; spreads;) {
    spreads = false;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const Joint& joint = model.joints[j];
      if (joint.modes[static_cast<std::size_t>(middle_.joints[j].mode)].rows == 0) continue;
      const std::vector<int> pair = list_joint_bodies(model, static_cast<int>(j));
      const bool any = std::ranges::any_of(pair, [this](int body) { return left_out_[at(body)]; });
      for (const int body : pair) {
        spreads = spreads || (any && !left_out_[at(body)]);
        left_out_[at(body)] = left_out_[at(body)] || any;
      }
    }
  }
}

void FeedbackAudit::set_middle(const MotionKnot& from, const MotionKnot& to) {
  std::memcpy(middle_.get_bytes().data(), from.state.get_bytes().data(), from.state.get_bytes().size());
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const BodyState &begin = from.state.bodies[b], &end = to.state.bodies[b];
    middle_.bodies[b] = {0.5 * (begin.p + end.p), find_middle(begin.q, end.q), 0.5 * (begin.v + end.v),
                         0.5 * (begin.w + end.w)};
  }
}

// How much of the changes is a small part of what was flown.
double FeedbackAudit::find_part() const {
  double part = HUGE_VAL;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const Course& course = courses_[b];
    if (!course.suspect || left_out_[b]) continue;
    const auto limit = [&part](double flown, double change) {
      if (change > 0) part = std::min(part, kSmall * flown / change);
    };
    const double place = std::max(kLeast, kFar * norm(middle_.bodies[b].p));
    for (const bool turns : {false, true}) {
      const double most = turns ? course.most_w : course.most_v;
      limit(std::max(get_size(course.by, turns), std::max(kLeast, kLeastPart * most)),
            get_size(changes_[b].velocity, turns));
      limit(std::max(get_size(course.moved, turns), turns ? kLeast : place), get_size(changes_[b].place, turns));
    }
  }
  return part;
}

// Multiplies the changes by the derivative, with this part of them as the width. False where the state has no
// accelerations.
bool FeedbackAudit::apply(double part, Workspace& workspace) {
  std::memcpy(state_.get_bytes().data(), middle_.get_bytes().data(), middle_.get_bytes().size());
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    const Change& change = changes_[b];
    BodyState& body = state_.bodies[b];
    const Vec3 w = rotation_matrix(body.q) * body.w + part * change.velocity.ang;
    body.p += part * change.place.lin;
    body.q = turn(body.q, part * change.place.ang);
    body.v += part * change.velocity.lin;
    body.w = transpose_times(rotation_matrix(body.q), w);
  }
  return update_outputs(simulation_.plan(), Inputs{simulation_.get_inputs()}, state_, workspace) == StepStatus::kOk;
}

void FeedbackAudit::measure(const MotionKnot& from, const MotionKnot& to, Workspace& workspace) {
  set_middle(from, to);
  list_left_out();
  bool any = false;
  for (std::size_t b = 0; b < courses_.size(); ++b) any = any || (courses_[b].suspect && !left_out_[b]);
  if (!any) return;
  const double time = to.time - from.time;
  if (update_outputs(simulation_.plan(), Inputs{simulation_.get_inputs()}, middle_, workspace) != StepStatus::kOk)
    return;
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    accelerations_[b] = workspace.accelerations[b];
    const BodyState& begin = from.state.bodies[b];
    const Spatial& a = from.accelerations[b];
    changes_[b] = {};
    if (!left_out_[b])
      changes_[b] = {{time * begin.v, time * (rotation_matrix(begin.q) * begin.w)}, {time * a.lin, time * a.ang}};
  }
  taken_ = changes_;
  for (int power = 1; power <= kPowers; ++power) {
    const double part = find_part();
    if (!std::isfinite(part) || !apply(part, workspace)) return;
    for (std::size_t b = 0; b < courses_.size(); ++b) {
      if (left_out_[b]) continue;
      const Spatial a = workspace.accelerations[b];
      const double per = time / part;
      changes_[b] = {{time * changes_[b].velocity.lin, time * changes_[b].velocity.ang},
                     {per * (a.lin - accelerations_[b].lin), per * (a.ang - accelerations_[b].ang)}};
    }
    if (power == 1) first_ = changes_;
  }
  for (std::size_t b = 0; b < courses_.size(); ++b) {
    if (!courses_[b].suspect || left_out_[b]) continue;
    if (const FeedbackError error = judge(b, time); error.rate > 0) add(error);
  }
}

// From the powers of the derivative. An oscillation has no acceleration where it is fastest: its rate is that which
// both the power 0 and the power 1 admit.
FeedbackError FeedbackAudit::judge(std::size_t b, double time) const {
  FeedbackError error{.body = static_cast<int>(b)};
  // Of a step that was not split the halves tell the error, unless it is far too long.
  const bool is_split = time < kWhole * simulation_.plan().get_options().dt;
  const double limit = is_split ? kUnresolvedSize : kResolved;
  for (const bool turns : {false, true}) {
    const double least = std::max(kLeast, kLeastPart * (turns ? courses_[b].most_w : courses_[b].most_v));
    const double own = get_size(taken_[b].velocity, turns), next = get_size(first_[b].velocity, turns);
    const double last = get_size(changes_[b].velocity, turns);
    if (!(last / kTallest > least)) continue;
    const double size = std::min(own > 0 ? std::sqrt(std::sqrt(last / own)) : HUGE_VAL, std::cbrt(last / next));
    if (!(size > limit)) continue;
    // No more than Euler's method would be off by.
    const double most = std::max(own, next);
    const double of_velocity = std::min(last / kTallest, most);
    const double of_place = std::min(get_size(changes_[b].place, turns) / kTallest, time * most);
    const auto set = [&error](MotionPart part, double value) { error.error[at(static_cast<int>(part))] = value; };
    set(turns ? MotionPart::kAttitude : MotionPart::kPlace, of_place);
    set(turns ? MotionPart::kRate : MotionPart::kVelocity, of_velocity);
    error.rate = std::max(error.rate, size / time);
  }
  return error;
}

// A body has one entry, the sum of the pieces of the step.
void FeedbackAudit::add(const FeedbackError& error) {
  const auto own = std::ranges::find(errors_, error.body, &FeedbackError::body);
  if (own == errors_.end()) {
    errors_.push_back(error);
    return;
  }
  own->rate = std::max(own->rate, error.rate);
  for (std::size_t i = 0; i < error.error.size(); ++i) own->error[i] += error.error[i];
}

}  // namespace unlatch::hil
