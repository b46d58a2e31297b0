#include "hil/run/analysis/requirements.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "hil/run/analysis/assemblies.h"
#include "hil/run/analysis/extreme_verdict.h"
#include "hil/run/extremes/straight_quantity.h"
#include "hil/run/notices/format.h"
#include "hil/scenario/base/from_eigen.h"
#include "hil/scenario/base/index.h"
#include "hil/scenario/text/count.h"
#include "unlatch/contacts.h"
#include "unlatch/geometry.h"
#include "unlatch/model/law_places.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {
namespace {

using Measure = Requirement::Measure;
using Take = Requirement::Take;

constexpr double kTwoPi = 6.283185307179586;

bool takes_low(Take take) { return take != Take::kMaximum && take != Take::kFinal; }
bool takes_high(Take take) { return take != Take::kMinimum && take != Take::kFinal; }

// True for the smallest clearance of the whole run: the clearance history finds it, and computes only distances that
// can be the smallest.
bool is_smallest_clearance(const Requirement& r) {
  return r.quantity == Measure::kClearance && r.take == Take::kMinimum && !r.at.is_named() && !r.from.is_named() &&
         !r.to.is_named();
}

// True for the force and the depth of a contact: poses and velocities of the bodies determine them.
bool is_of_motion(const Requirement& r) {
  using Value = Requirement::ContactValue;
  const auto value = static_cast<Value>(r.axis);
  return r.quantity == Measure::kContact && (value == Value::kForce || value == Value::kDepth);
}

// True for quantities that are known at knots alone.
bool is_sampled(const Requirement& r) {
  return r.quantity == Measure::kReaction || r.quantity == Measure::kSensor || r.quantity == Measure::kQuantity ||
         (r.quantity == Measure::kContact && !is_of_motion(r));
}

// What of a quantity that is known at knots alone has no corner.
SmoothPart find_smooth_part(const Model& model, const Requirement& r) {
  if (r.quantity == Measure::kReaction || r.quantity == Measure::kSensor)
    return r.axis < 0 ? SmoothPart::kSquare : SmoothPart::kItself;
  if (r.quantity != Measure::kQuantity) return SmoothPart::kItself;
  return hil::find_smooth_part(model.quantities[at(r.a)]);
}

// The quantity that is a law and that the requirement is on, itself or by a sensor's true value; none.
int find_law(const Model& model, const Requirement& r) {
  int quantity = kNone;
  if (r.quantity == Measure::kQuantity) quantity = r.a;
  if (r.quantity == Measure::kSensor && !r.received && model.sensors[at(r.a)].kind == Sensor::Kind::kQuantity)
    quantity = model.sensors[at(r.a)].subject;
  const bool is_law = quantity != kNone && model.quantities[at(quantity)].kind == unlatch::Quantity::Kind::kLaw;
  return is_law ? quantity : kNone;
}

// The quantity that it is on, itself or as a sensor measures it; none.
std::optional<unlatch::Quantity> find_quantity(const Model& model, const Requirement& r) {
  if (r.quantity == Measure::kQuantity) return model.quantities[at(r.a)];
  if (r.quantity == Measure::kSensor) return get_quantity(model, model.sensors[at(r.a)]);
  return std::nullopt;
}

// Quantities that it is on: itself, as a sensor measures it, or those that the expression reads that it is.
std::vector<unlatch::Quantity> list_quantities(const Model& model, const Requirement& r) {
  std::vector<unlatch::Quantity> list;
  if (const int law = find_law(model, r); law != kNone) {
    for (const int own : list_laws_behind(model, model.quantities[at(law)].subject))
      for (const LawStep& step : model.laws[at(own)].steps)
        if (step.kind == LawStep::Kind::kQuantity) list.push_back(model.quantities[at(step.subject)]);
  } else if (const std::optional<unlatch::Quantity> of = find_quantity(model, r)) {
    list.push_back(*of);
  }
  return list;
}

// Size of a surface, as its body has it, m; 0 of one without bounds.
double calc_size(const Model& model, int surface) {
  const geometry::ShapeGroup group = geometry::build_group({}, model.surfaces[at(surface)].shapes);
  return std::isfinite(group.bound) ? group.bound + norm(group.centre) : 0;
}

// How deep a located touch of a rigid contact between two bodies may be, m.
double get_touch_error(const Model& model, int a, int b) {
  constexpr double kLocated = 1e-8;
  const bool touches = std::ranges::any_of(model.contacts, [&](const Contact& contact) {
    const int base = model.surfaces[at(contact.base)].body, follower = model.surfaces[at(contact.follower)].body;
    return contact.rigid && std::minmax(base, follower) == std::minmax(a, b);
  });
  return touches ? kLocated : 0;
}

// Error of a quantity that is a distance, m; else 0.
double get_error(const Model& model, const Requirement& r) {
  const std::optional<unlatch::Quantity> of = find_quantity(model, r);
  if (!of || of->kind != unlatch::Quantity::Kind::kClearance) return 0;
  const double size = std::max(calc_size(model, of->subject), calc_size(model, of->other));
  return std::max(ClearanceHistory::kDistanceError * size,
                  get_touch_error(model, model.surfaces[at(of->subject)].body, model.surfaces[at(of->other)].body));
}

// Joints whose reactions it is or reads.
std::vector<int> list_reactions(const Model& model, const Requirement& r) {
  std::vector<int> joints;
  if (r.quantity == Measure::kReaction) joints.push_back(r.a);
  for (const unlatch::Quantity& quantity : list_quantities(model, r))
    if (get_traits(quantity.kind).of_reaction) joints.push_back(quantity.subject);
  return joints;
}

// Contacts whose forces it is or reads.
std::vector<int> list_contact_forces(const Model& model, const Requirement& r) {
  std::vector<int> contacts;
  const bool is_force = r.quantity == Measure::kContact &&
                        static_cast<Requirement::ContactValue>(r.axis) == Requirement::ContactValue::kForce;
  if (is_force) contacts.push_back(r.a);
  for (const unlatch::Quantity& quantity : list_quantities(model, r))
    if (quantity.kind == unlatch::Quantity::Kind::kContactForce) contacts.push_back(quantity.subject);
  return contacts;
}

// True if it is of this kind, or an expression that reads some of it.
template <class IsSuch>
bool reads_some(const Model& model, const Requirement& r, const IsSuch& is_such) {
  return std::ranges::any_of(list_quantities(model, r), [&](const unlatch::Quantity& quantity) {
    return is_such(get_traits(quantity.kind).motion);
  });
}

// True of reactions, forces and accelerations, and of expressions that read some.
bool may_jump(const Model& model, const Requirement& r) {
  const auto is_force = [](QuantityMotion motion) { return motion == QuantityMotion::kForces; };
  return r.quantity == Measure::kReaction || reads_some(model, r, is_force);
}

// True of an expression that has no corner where the motion has one, of its accelerations: it reads places alone.
bool goes_through_corners(const Model& model, const Requirement& r) {
  const auto has_corner = [](QuantityMotion motion) {
    return motion == QuantityMotion::kForces || motion == QuantityMotion::kSpeeds || motion == QuantityMotion::kOfAll;
  };
  return find_law(model, r) != kNone && !reads_some(model, r, has_corner);
}

bool goes_straight(const Model& model, const Requirement& r) {
  const std::optional<unlatch::Quantity> of = r.received ? std::nullopt : find_quantity(model, r);
  return of && is_straight(get_traits(of->kind));
}

// Change of a velocity at an event, relative to the largest of the assembly, beyond which it is a blow, not rounding.
constexpr double kBlow = 1e-9, kStill = 1e-12;  // kStill: rounding of bodies at rest, m/s, rad/s

// True if the velocity or the rate of one of these bodies has changed.
bool has_jump(const std::vector<int>& bodies, const State& before, const State& after) {
  double speed = 0, rate = 0, change = 0, turn = 0;
  for (const int body : bodies) {
    if (body == kGround) continue;
    const auto &old = before.bodies[at(body)], &now = after.bodies[at(body)];
    speed = std::max({speed, norm(old.v), norm(now.v)});
    rate = std::max({rate, norm(old.w), norm(now.w)});
    change = std::max(change, norm(now.v - old.v));
    turn = std::max(turn, norm(now.w - old.w));
  }
  return change > kBlow * speed + kStill || turn > kBlow * rate + kStill;
}

// Returns the component of a vector along a direction, or its size if the direction is zero.
double take_part(const Vec3& v, const Eigen::Vector3d& direction) {
  return direction.isZero(0) ? norm(v) : dot(v, to_vec3(direction));
}

// Sets value, limit and margin; of two limits the nearer one counts.
void set_margin(const Requirement& requirement, double value, double time, Verdict& verdict) {
  const double above = value - requirement.least, below = requirement.most - value;
  verdict.evaluated = true;
  verdict.value = value;
  verdict.time = time;
  verdict.margin = std::min(above, below);
  verdict.limit = above <= below ? requirement.least : requirement.most;
}

}  // namespace

bool is_bounded(const Model& model, const Requirement& requirement) {
  return !requirement.is_of_events() && is_sampled(requirement) && !requirement.received &&
         !goes_straight(model, requirement) && !requirement.at.is_named() && requirement.take != Take::kFinal;
}

// --- The quantities -------------------------------------------------------------------------------------------------

RequirementMonitor::RequirementMonitor(const Scenario& scenario, const Simulation& simulation,
                                       const ClearanceHistory& clearances, const ContactHistory& contacts)
    : scenario_(scenario),
      simulation_(simulation),
      clearances_(clearances),
      contacts_(contacts),
      first_(scenario.model.events.size()) {
  const Model model = scenario.requirements.empty() ? Model{} : place_markers(scenario.model);
  for (const Requirement& requirement : scenario.requirements) {
    Track track;
    track.requirement = &requirement;
    const Measure quantity = requirement.quantity;
    if (quantity == Measure::kClearance) {
      track.pair = requirement.pair;
      track.low = track.high = Smallest(clearances.get_resolution(track.pair));
      track.tolerance =
          std::max(clearances.get_error(track.pair), get_touch_error(model, requirement.a, requirement.b));
    }
    if (quantity == Measure::kDisplacement || quantity == Measure::kAngle || quantity == Measure::kSpeed)
      track.joint.emplace(model, requirement.a);
    if (const int law = find_law(scenario.model, requirement); law != kNone)
      track.law.emplace(scenario.model, simulation.plan(), law,
                        LawExtremes::Sides{takes_low(requirement.take), takes_high(requirement.take)});
    if (quantity == Measure::kSensor && received_.empty())
      for (const Sensor& sensor : model.sensors) received_.resize(received_.size() + at(sensor_width(sensor.kind)));
    if (quantity == Measure::kSensor)
      for (int i = 0; i < requirement.a; ++i) track.first += at(sensor_width(model.sensors[at(i)].kind));
    if (!requirement.received) track.tolerance = std::max(track.tolerance, get_error(scenario.model, requirement));
    track.part = find_smooth_part(scenario.model, requirement);
    track.straight = goes_straight(scenario.model, requirement);
    if (!requirement.is_of_events()) {
      track.reactions = list_reactions(scenario.model, requirement);
      track.forces = list_contact_forces(scenario.model, requirement);
    }
    track.jumps = may_jump(scenario.model, requirement);
    track.counts_between = !requirement.is_of_events() && !requirement.received && !track.jumps && track.pair < 0 &&
                           !is_of_motion(requirement);
    track.goes_on = goes_through_corners(scenario.model, requirement);
    if (requirement.at.is_named() || requirement.from.is_named()) track.phase = Phase::kWaiting;
    track.bounded = is_bounded(scenario.model, requirement);
    if (!finer_ && track.bounded) finer_ = std::make_unique<FinerSteps>(simulation);
    tracks_.push_back(std::move(track));
  }
}

double RequirementMonitor::calc_sample(const Track& track, const MotionKnot& knot) const {
  const Requirement& r = *track.requirement;
  if (r.quantity == Measure::kQuantity) return knot.quantities[at(r.a)];
  std::span<const double> values = r.received ? std::span<const double>(received_) : knot.sensors;
  if (r.quantity == Measure::kContact)
    return contacts_.calc(knot.state, r.a, static_cast<Requirement::ContactValue>(r.axis));
  if (r.quantity == Measure::kReaction) {
    const std::size_t first = at(r.a) * kRows;
    if (r.axis >= 0) return knot.multipliers[first + at(r.axis)];
    values = knot.multipliers.subspan(first + (r.axis == Requirement::kForce ? 0 : kRotX), 3);
  } else {
    values = values.subspan(track.first, at(sensor_width(scenario_.model.sensors[at(r.a)].kind)));
    if (r.axis >= 0) return values[at(r.axis)];
  }
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum);
}

void RequirementMonitor::begin_step(const StepReport& report) {
  if (finer_) finer_->add(report);
}

FinerSource RequirementMonitor::get_finer(const Track& track) const {
  return {.steps = finer_.get(), .count = track.judged ? FinerSteps::Count::kNo : FinerSteps::Count::kYes};
}

// Distances of two surfaces between two knots, at interpolated poses.
class DistanceBetween {
 public:
  static constexpr int kParts = 16;

  DistanceBetween(const Plan& plan, const unlatch::Quantity& quantity)
      : plan_(plan),
        quantity_(quantity),
        block_(plan.get_state_bytes() / sizeof(std::uint64_t)),
        state_(plan, std::as_writable_bytes(std::span(block_))) {}

  double calc(const MotionKnot& from, const MotionKnot& to, double time) {
    const MotionPiece piece{from.time,          to.time,         from.state.bodies, to.state.bodies,
                            from.accelerations, to.accelerations};
    std::memcpy(block_.data(), from.state.get_bytes().data(), from.state.get_bytes().size());
    for (std::size_t b = 0; b < state_.bodies.size(); ++b) state_.bodies[b] = piece.calc_body(b, time);
    return calc_shape_distance(plan_, state_, quantity_.subject, quantity_.other).least.distance;
  }

 private:
  const Plan& plan_;
  const unlatch::Quantity quantity_;
  std::vector<std::uint64_t> block_;
  State state_;
};

// Values of a requirement in steps that are taken again; of a distance, between their knots too: two spheres that pass
// near each other may do so within one of the shorter steps.
class RequirementMonitor::FinerOfTrack final : public FinerValues {
 public:
  FinerOfTrack(const RequirementMonitor& monitor, const Track& track) : monitor_(monitor), track_(track) {}
  std::span<const ValueKnot> list(double from, double to) override {
    values_.clear();
    const Model& model = monitor_.scenario_.model;
    const Requirement& r = *track_.requirement;
    const std::optional<unlatch::Quantity> of = r.received ? std::nullopt : find_quantity(model, r);
    std::optional<DistanceBetween> distance;
    if (of && of->kind == unlatch::Quantity::Kind::kClearance) distance.emplace(monitor_.simulation_.plan(), *of);
    const FinerKnot* before = nullptr;
    for (const std::unique_ptr<FinerKnot>& own : monitor_.get_finer(track_).take(from, to).knots) {
      if (distance && before != nullptr && !own->begins)
        for (int i = 1; i < DistanceBetween::kParts; ++i) {
          const double part = static_cast<double>(i) / DistanceBetween::kParts;
          const double time = before->knot.time + part * (own->knot.time - before->knot.time);
          values_.push_back({time, distance->calc(before->knot, own->knot, time), false});
        }
      values_.push_back({own->knot.time, to_smooth(track_.part, monitor_.calc_sample(track_, own->knot)), own->begins});
      before = own.get();
    }
    return values_;
  }

 private:
  const RequirementMonitor& monitor_;
  const Track& track_;
  std::vector<ValueKnot> values_;
};

void RequirementMonitor::add_to_bounds(Track& track, double time, double value, bool begins) const {
  if (track.phase != Phase::kOpen || !track.bounded) return;
  FinerOfTrack finer(*this, track);
  track.bounds.add({time, to_smooth(track.part, value), begins}, &finer);
}

template <class BodyAt>
double RequirementMonitor::calc_of_bodies(const Track& track, const BodyAt& body_at) const {
  const Requirement& r = *track.requirement;
  if (track.joint) {
    const BodyState base = body_at(track.joint->get_base()), follower = body_at(track.joint->get_follower());
    if (r.quantity == Measure::kSpeed) return track.joint->calc_speed(base, follower, r.axis);
    const double value = track.joint->calc_coordinate(base, follower, r.axis);
    if (r.quantity == Measure::kDisplacement) return value;
    return value - kTwoPi * std::nearbyint((value - (track.has_last ? track.last : value)) / kTwoPi);  // turns counted
  }
  const BodyState a = body_at(r.a), b = body_at(r.b);
  const Mat3 R_a = rotation_matrix(a.q), R_b = rotation_matrix(b.q);
  switch (r.quantity) {
    case Measure::kRate:
      return std::abs(take_part(a.w - transpose_times(R_a, R_b * b.w), r.direction));
    case Measure::kVelocity:
      return take_part(transpose_times(R_b, a.v - b.v), r.direction);
    case Measure::kPosition:
      return take_part(transpose_times(R_b, a.p - b.p), r.direction);
    default: {
      const Vec3 axis = R_a * to_vec3(r.direction), other = R_b * to_vec3(r.other);
      return std::atan2(norm(cross(axis, other)), dot(axis, other));
    }
  }
}

double RequirementMonitor::calc_at(const Track& track, const MotionKnot& knot) const {
  if (is_sampled(*track.requirement) || is_of_motion(*track.requirement)) return calc_sample(track, knot);
  if (track.pair >= 0) return clearances_.get_now(track.pair);
  return calc_of_bodies(track, [&](int body) { return body < 0 ? get_rest() : knot.state.bodies[at(body)]; });
}

double RequirementMonitor::calc_within(const Track& track, const MotionWindow& window, double time) const {
  const Requirement& r = *track.requirement;
  if (r.received) return track.last;
  if (is_of_motion(r)) {
    const ContactReading reading = contacts_.calc(window, r.a, time);
    return static_cast<Requirement::ContactValue>(r.axis) == Requirement::ContactValue::kForce ? reading.normal
                                                                                               : reading.depth;
  }
  if (track.pair >= 0) return clearances_.calc(window, track.pair, time);
  return calc_of_bodies(track, [&](int body) { return window.calc_body(body, time); });
}

// --- The run --------------------------------------------------------------------------------------------------------

namespace {

// The contact for which alone an event waits, to close or to open.
std::optional<int> find_awaited_contact(const Event& event) {
  const Condition* when = &event.when;
  if (when->kind == Condition::Kind::kNot) when = when->parts.data();
  return when->kind == Condition::Kind::kClosed && event.delay == 0 ? std::optional(when->subject) : std::nullopt;
}

}  // namespace

// An event without actions that waits for a contact alone, such as its touch, stands for what the contact does: it is
// of the round in which that closed or opened, which is before the one in which the event is due.
std::vector<RequirementMonitor::Acted> RequirementMonitor::list_acted(std::span<const EventRound> rounds) const {
  std::vector<Acted> acted;
  for (std::size_t i = 0; i < rounds.size(); ++i)
    for (const FiredEvent& fired : rounds[i].events) {
      const Event& event = scenario_.model.events[at(fired.event)];
      const std::optional<int> contact = event.then.empty() ? find_awaited_contact(event) : std::nullopt;
      std::size_t own = i;
      if (contact && !rounds[i].is_lost) {
        const auto is_closed = [&](std::size_t k) {
          return contacts_.is_closed(rounds[k].before->state, at(*contact));
        };
        while (own > 0 && is_closed(own) == is_closed(i)) --own;
        if (is_closed(own) == is_closed(i)) own = i;
      }
      acted.push_back({fired, own});
    }
  return acted;
}

void RequirementMonitor::add_times(std::span<const Acted> acted) {
  for (const Acted& own : acted) {
    Occurrence& first = first_[at(own.fired.event)];
    if (!first.is_known()) first = {own.fired.time, rounds_ + own.round};
  }
  for (Track& track : tracks_) {
    const std::vector<EventName>& names = track.requirement->events;
    if (track.requirement->quantity != Measure::kTime || names.size() < 2 || std::isfinite(track.next)) continue;
    if (names[0].event == kNone || names[1].event == kNone) continue;
    const Occurrence& after = first_[at(names[1].event)];
    for (const Acted& own : acted)
      if (own.fired.event == names[0].event && after.is_known() && rounds_ + own.round >= after.round)
        track.next = own.fired.time;
  }
}

void RequirementMonitor::add_events(std::span<const EventRound> rounds) {
  const std::vector<Acted> acted = list_acted(rounds);
  add_times(acted);
  for (std::size_t i = 0; i < rounds.size(); ++i)
    for (Track& track : tracks_)
      if (!track.requirement->is_of_events()) add_round(track, rounds, i, acted);
  rounds_ += rounds.size();
}

void RequirementMonitor::add_round(Track& track, std::span<const EventRound> rounds, std::size_t number,
                                   std::span<const Acted> acted) {
  const Requirement& r = *track.requirement;
  const EventRound& round = rounds[number];
  const MotionKnot &before = *round.before, &after = *round.after;
  const auto is_here = [&](const EventName& name) {
    return name.is_named() && std::ranges::any_of(acted, [&](const Acted& own) {
             return own.fired.event == name.event && own.round == number;
           });
  };
  const bool ends = track.phase == Phase::kOpen && is_here(r.to);
  if (!ends) add_blow(track, before, after);
  if (ends) {
    if (window_ != nullptr) finish(track, *window_);
    if (number > 0) {
      track.last = calc_at(track, before);
      track.last_time = before.time;
    }
    track.phase = Phase::kClosed;
    track.end = after.time;
    track.lost = track.lost || round.is_lost;
  } else if (track.phase == Phase::kWaiting && is_here(r.at)) {
    track.last = calc_at(track, before);
    track.last_time = before.time;
    track.has_last = true;
    track.phase = Phase::kClosed;
    track.lost = round.is_lost;
  } else if (track.phase == Phase::kWaiting && is_here(r.from)) {
    track.phase = Phase::kOpen;
    track.fresh = true;
    track.last = calc_at(track, after);
    track.last_time = after.time;
    track.has_last = true;
    track.lost = round.is_lost;
    track.low.add(after.time, track.last);
    track.high.add(after.time, -track.last);
    if (track.law) track.law->take(after.time, track.last);
    track.bounds.take(after.time, to_smooth(track.part, track.last));
  } else if (track.phase == Phase::kOpen && track.counts_between && number + 1 < rounds.size()) {
    const double value = calc_at(track, after);
    take(track, after.time, value);
    if (track.law) track.law->take(after.time, value);
    track.bounds.take(after.time, to_smooth(track.part, value));
  }
}

// A blow that changes the velocity of a body to which a joint leads, over joints that hold, passes through the joint;
// one through a contact is in its impulse.
void RequirementMonitor::add_blow(Track& track, const MotionKnot& before, const MotionKnot& after) const {
  if (std::isfinite(track.blow) || track.phase != Phase::kOpen) return;
  const auto passes_joint = [&](int number) {
    const Joint& joint = scenario_.model.joints[at(number)];
    const std::vector<int> bodies = Assemblies(scenario_.model, after.state).list(joint.follower);
    const bool holds = std::ranges::find(bodies, joint.base) != bodies.end();
    return holds && has_jump(bodies, before.state, after.state);
  };
  const auto passes_contact = [&](int contact) {
    const Plan& plan = simulation_.plan();
    return get_contact_totals(plan, after.state, contact).impulse !=
           get_contact_totals(plan, before.state, contact).impulse;
  };
  if (std::ranges::any_of(track.reactions, passes_joint) || std::ranges::any_of(track.forces, passes_contact))
    track.blow = after.time;
}

// Searches the latest interval. Before the first one, and where the search goes on from a knot after a gap, there is
// none.
void RequirementMonitor::finish(Track& track, const MotionWindow& window) const {
  if (track.fresh || track.straight) return;
  if (track.law) return track.law->finish(get_finer(track));
  if (track.bounded) {
    FinerOfTrack finer(*this, track);
    track.bounds.finish(&finer);
    return;
  }
  track.low.finish([&](double time) { return calc_within(track, window, time); });
  track.high.finish([&](double time) { return -calc_within(track, window, time); });
}

void RequirementMonitor::take(Track& track, double time, double value) {
  track.low.take(time, value);
  track.high.take(time, -value);
}

void RequirementMonitor::add_piece(const MotionWindow& window, const MotionKnot& from, const MotionKnot& to,
                                   std::span<const double> commands, bool switched) {
  window_ = &window;
  for (Track& track : tracks_) {
    const Requirement& r = *track.requirement;
    if (r.is_of_events() || r.received) continue;
    // Turns of an angle are counted from the beginning of the run, whatever the interval.
    if (track.phase == Phase::kClosed || (track.phase == Phase::kWaiting && r.quantity != Measure::kAngle)) continue;
    if (is_smallest_clearance(r)) {
      track.has_last = true;
      continue;
    }
    // The smallest clearance does not fall below what it is in this piece.
    if (track.pair >= 0 && r.take == Take::kMinimum && track.low.has_value() &&
        clearances_.stays_above(track.pair, track.low.get_value())) {
      finish(track, window);
      track.fresh = track.skips = true;
      track.has_last = true;
      continue;
    }
    track.skips = false;
    // One piece shows that a contact which stays open has no force and no depth.
    const bool apart = is_of_motion(r) && !contacts_.is_closed(from.state, at(r.a));
    if (apart && track.apart) {
      track.fresh = true;
      track.last_time = to.time;
      continue;
    }
    track.apart = apart;
    const bool begins =
        track.fresh || (switched && track.jumps) || !(track.goes_on ? window.is_continuous() : window.is_smooth());
    double start = track.last;
    if (begins) start = track.pair >= 0 ? clearances_.calc(window, track.pair, from.time) : calc_at(track, from);
    if (begins) finish(track, window);
    if (track.law) {
      track.last = calc_at(track, to);
      track.last_time = to.time;
      track.has_last = true;
      if (track.phase == Phase::kOpen) track.law->add(from, to, commands, begins, get_finer(track));
      track.fresh = false;
      continue;
    }
    if (track.straight) {
      track.last = calc_at(track, to);
      track.last_time = to.time;
      track.has_last = true;
      if (track.phase == Phase::kOpen) {
        if (begins) take(track, from.time, start);
        take(track, to.time, track.last);
      }
      track.fresh = false;
      continue;
    }
    track.last = start;
    track.has_last = true;
    const double end = calc_at(track, to);
    if (is_sampled(r)) {
      if (begins) add_to_bounds(track, from.time, start, true);
      add_to_bounds(track, to.time, end, false);
      track.last = end;
      track.last_time = to.time;
      track.fresh = false;
      continue;
    }
    if (track.phase == Phase::kOpen && takes_low(r.take))
      track.low.add(from.time, start, to.time, end, begins,
                    [&](double time) { return calc_within(track, window, time); });
    if (track.phase == Phase::kOpen && takes_high(r.take)) {
      track.high.add(from.time, -start, to.time, -end, begins,
                     [&](double time) { return -calc_within(track, window, time); });
    }
    track.last = end;
    track.last_time = to.time;
    track.fresh = false;
  }
}

void RequirementMonitor::add_received(double time, std::span<const double> values) {
  if (received_.empty()) return;
  std::ranges::copy(values, received_.begin());
  for (Track& track : tracks_) {
    if (!track.requirement->received || track.phase != Phase::kOpen) continue;
    track.last = calc_sample(track, {});
    track.last_time = time;
    track.has_last = true;
    track.low.add(time, track.last);
    track.high.add(time, -track.last);
  }
}

double RequirementMonitor::get_end(std::size_t i) const { return tracks_[i].end; }

double RequirementMonitor::get_now(std::size_t i) const {
  const Track& track = tracks_[i];
  const bool open = track.phase == Phase::kOpen && track.has_last && !track.requirement->is_of_events();
  if (!open) return std::nan("");
  return track.skips || is_smallest_clearance(*track.requirement) ? clearances_.get_now(track.pair) : track.last;
}

// --- The verdict ----------------------------------------------------------------------------------------------------

const EventName* RequirementMonitor::find_missing(const Requirement& requirement) const {
  std::vector<const EventName*> names{&requirement.at, &requirement.from, &requirement.to};
  for (const EventName& name : requirement.events) names.push_back(&name);
  for (const EventName* name : names)
    if (name->is_named() && (name->event == kNone || !first_[at(name->event)].is_known())) return name;
  return nullptr;
}

Verdict RequirementMonitor::judge_times(const Track& track) const {
  const Requirement& requirement = *track.requirement;
  const std::vector<EventName>& names = requirement.events;
  Verdict verdict;
  const auto get = [&](std::size_t i) { return first_[at(names[i].event)]; };
  if (requirement.quantity == Measure::kTime) {
    const double time = std::isfinite(track.next) ? track.next : get(0).time;
    set_margin(requirement, time - (names.size() > 1 ? get(1).time : 0), time, verdict);
    return verdict;
  }
  const auto calc_time = [&](std::size_t i) { return get(i).time - get(i - 1).time; };
  const auto is_reversed = [&](std::size_t i) { return calc_time(i) == 0 && get(i).round < get(i - 1).round; };
  std::size_t worst = 1;
  for (std::size_t i = 1; i < names.size(); ++i)
    if (calc_time(i) < calc_time(worst) || (calc_time(i) == calc_time(worst) && is_reversed(i))) worst = i;
  set_margin(requirement, calc_time(worst), get(worst).time, verdict);
  // Events of one instant have an order, but no time between them that could be missed.
  if (is_reversed(worst) && verdict.margin == 0) {
    verdict.evaluated = false;
    verdict.why = "event '" + names[worst].text + "' acted before '" + names[worst - 1].text + "', both at " +
                  format("%.6g s", verdict.time);
  }
  return verdict;
}

Verdict RequirementMonitor::judge(Track track, const MotionWindow& window) const {
  track.judged = true;
  const Requirement& r = *track.requirement;
  Verdict verdict;
  if (const EventName* missing = find_missing(r)) {
    verdict.why = "event '" + missing->text + (missing->event == kNone ? "' is left out" : "' did not occur");
    return verdict;
  }
  if (r.is_of_events()) return judge_times(track);
  if (track.phase == Phase::kOpen && r.to.is_named()) {
    verdict.why = "event '" + r.to.text + "' did not occur after '" + r.from.text + "'";
    return verdict;
  }
  if (track.lost) {
    verdict.why = "the state between the events of its instant is not known: they acted in more than " +
                  count(MotionLog::kMostRounds, "round") + " within one step";
    return verdict;
  }
  if (!track.has_last) {
    verdict.why = "the run has no step in its interval";
    return verdict;
  }
  if (r.at.is_named() || r.take == Take::kFinal) {
    set_margin(r, track.last, track.last_time, verdict);
    return verdict;
  }
  if (is_smallest_clearance(r)) {
    // The latest interval is searched when the next one arrives, or here.
    const MotionPiece& piece = window.get_present();
    const Clearance& clearance = clearances_.get()[at(track.pair)];
    const auto function = [&](double time) { return calc_within(track, window, time); };
    track.low.add(clearance.time, clearance.smallest);
    track.low.add(piece.from, function(piece.from), piece.to, clearance.now, true, function);
  } else if (track.phase == Phase::kOpen) {
    finish(track, window);
  }
  if (track.bounded && !track.law) {
    const ExtremeBounds::Bound &least = track.bounds.get_low(), &most = track.bounds.get_high();
    track.low.take(least.found, from_smooth(track.part, least.value));
    track.high.take(most.found, -from_smooth(track.part, -most.value));
  }
  const Smallest& least = track.law ? track.law->get_low().value : track.low;
  const Smallest& most = track.law ? track.law->get_high().value : track.high;
  const double low = least.get_value(), high = -most.get_value();
  const double low_time = least.get_time(), high_time = most.get_time();
  switch (r.take) {
    case Take::kMinimum:
      set_margin(r, low, low_time, verdict);
      break;
    case Take::kMaximum:
      set_margin(r, high, high_time, verdict);
      break;
    case Take::kPeak:
      set_margin(r, std::max(-low, high), -low > high ? low_time : high_time, verdict);
      break;
    default:
      if (low - r.least <= r.most - high) {
        set_margin(r, low, low_time, verdict);
        verdict.limit = r.least;
        verdict.margin = low - r.least;
      } else {
        set_margin(r, high, high_time, verdict);
        verdict.limit = r.most;
        verdict.margin = r.most - high;
      }
  }
  if (!track.bounded) return verdict;
  const auto get = [](const LawCurve::Found& own) {
    const double value = own.value.get_value();
    return ExtremeBounds::Bound{.least = std::min(own.least, value),
                                .most = std::max(own.most, value),
                                .time = own.value.get_time(),
                                .value = value,
                                .unsearched = own.unsearched};
  };
  judge_extreme(r,
                {.low = low,
                 .high = high,
                 .least = track.law ? get(track.law->get_low()) : track.bounds.get_low(),
                 .most = track.law ? get(track.law->get_high()) : track.bounds.get_high(),
                 .part = track.law ? SmoothPart::kItself : track.part},
                scenario_.dt, verdict);
  return verdict;
}

std::vector<Verdict> RequirementMonitor::judge(const MotionWindow& window) const {
  std::vector<Verdict> verdicts;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    verdicts.push_back(judge(tracks_[i], window));
    Verdict& verdict = verdicts.back();
    verdict.requirement = i;
    // Rounding of a distance that is its limit decides nothing.
    if (verdict.evaluated && verdict.margin < 0 && verdict.margin >= -tracks_[i].tolerance) verdict.margin = 0;
    if (tracks_[i].requirement->take != Take::kFinal) verdict.blow = tracks_[i].blow;
  }
  return verdicts;
}

}  // namespace unlatch::hil
