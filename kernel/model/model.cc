#include "unlatch/model.h"

#include <algorithm>

#include "unlatch/model/contact_substeps.h"
#include "unlatch/quantities.h"

namespace unlatch {

const char* const kRowNames[kRows] = {"x", "y", "z", "rot_x", "rot_y", "rot_z"};

int sensor_width(Sensor::Kind kind) {
  if (kind == Sensor::Kind::kQuantity) return 1;
  const Quantity quantity = get_quantity({}, Sensor{.name = {}, .kind = kind});
  return quantity.part == Quantity::kAll ? count_values(get_traits(quantity.kind)) : 1;
}

const char* sensor_unit(Sensor::Kind kind) {
  if (kind == Sensor::Kind::kQuantity) return "";
  if (kind == Sensor::Kind::kReaction) return "N, N m";   // along or about a row: both units are named
  if (kind == Sensor::Kind::kSpeed) return "m/s, rad/s";  // likewise
  return get_traits(get_quantity({}, Sensor{.name = {}, .kind = kind}).kind).unit;
}

void add_contact_events(Model& model) {
  for (int i = 0; i < static_cast<int>(model.contacts.size()); ++i) {
    Condition closed, open;
    closed.kind = Condition::Kind::kClosed;
    closed.subject = i;
    open.kind = Condition::Kind::kNot;
    open.parts = {closed};
    const std::string& name = model.contacts[static_cast<std::size_t>(i)].name;
    for (const auto& [event, when] : {std::pair("touch", closed), std::pair("lift", open)}) {
      Event& added = model.events.emplace_back();
      added.name = event;
      added.subject = name;
      added.when = when;
      added.repeat = added.crossing = true;
    }
  }
}

bool has_markers(const Model& model) {
  return std::any_of(model.bodies.begin(), model.bodies.end(),
                     [](const Body& body) { return body.marker.has_value(); });
}

// As calc_marker_state() of flexible.h. A marker that validate() would report stays as it is.
Model place_markers(const Model& model) {
  Model out = model;
  for (Body& body : out.bodies) {
    if (!body.marker || body.marker->body < 0 || static_cast<std::size_t>(body.marker->body) >= model.bodies.size())
      continue;
    const Body& carrier = model.bodies[static_cast<std::size_t>(body.marker->body)];
    if (!carrier.flexible) continue;
    const Eigen::Index m = carrier.flexible->frequencies.size();
    if (body.marker->shape.cols() != m || body.marker->turn.cols() != m) continue;
    const auto get = [m](const Eigen::VectorXd& v) { return v.size() == m ? v : Eigen::VectorXd::Zero(m).eval(); };
    const Eigen::VectorXd eta = get(carrier.flexible->initial), rate = get(carrier.flexible->initial_rate);
    const Eigen::Vector3d u = body.marker->position + body.marker->shape * eta;
    const Eigen::Vector3d g = 0.5 * body.marker->turn * eta, g_rate = 0.5 * body.marker->turn * rate;
    const Eigen::Quaterniond q = carrier.q_WB.normalized();
    const Eigen::Quaterniond turn = Eigen::Quaterniond(1, g.x(), g.y(), g.z()).normalized();
    const Eigen::Vector3d w_rel = 2 / (1 + g.squaredNorm()) * (g_rate + g.cross(g_rate));
    body.p_WB = carrier.p_WB + q * u;
    body.q_WB = q * turn;
    body.v_WB = carrier.v_WB + q * (carrier.w_WB_B.cross(u) + body.marker->shape * rate);
    body.w_WB_B = turn.conjugate() * (carrier.w_WB_B + w_rel);
  }
  return out;
}

namespace {

bool engages(const Event& event, int number) {
  return std::any_of(event.then.begin(), event.then.end(), [number](const Action& action) {
    return action.kind == Action::Kind::kEngage && action.subject == number;
  });
}

Event make_reach_event(const OneSided& force, int number, bool touches) {
  const bool pusher = force.kind == OneSided::Kind::kPusher, cord = force.kind == OneSided::Kind::kCord;
  Event event;
  event.name = touches ? (cord ? "taut" : "touch") : (cord ? "slack" : (pusher ? "stroke_end" : "lift"));
  event.subject = force.name;
  event.when.kind = Condition::Kind::kReach;
  event.when.subject = number;
  event.when.below = !touches;
  event.then = {{.kind = Action::Kind::kEngage, .subject = number, .value = touches ? 1.0 : 0.0}};
  event.repeat = true;
  return event;
}

}  // namespace

Model complete_events(const Model& model) {
  Model out = model;
  for (std::size_t i = 0; i < model.one_sided.size(); ++i) {
    const int number = static_cast<int>(i);
    if (std::any_of(model.events.begin(), model.events.end(), [&](const Event& e) { return engages(e, number); }))
      continue;
    for (const bool touches : {true, false})
      out.events.push_back(make_reach_event(model.one_sided[i], number, touches));
  }
  return out;
}

int get_most_contact_substeps(const Model& model) {
  return has_automatic_parts(model.contact_substeps) ? kMaxAutomaticSubsteps : model.contact_substeps;
}

}  // namespace unlatch
