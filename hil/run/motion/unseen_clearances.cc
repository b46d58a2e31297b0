#include "hil/run/motion/unseen_clearances.h"

#include <numeric>
#include <utility>

#include "hil/run/motion/relative_motion.h"
#include "hil/scenario/base/index.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {

// The guards of a scenario and what a monitor of theirs needs.
struct UnseenClearances::Listed {
  std::vector<Guard> guards;
  std::vector<ClearancePair> pairs;
  std::vector<std::vector<BodyShape>> shapes;  // by body; those of surfaces, one surface behind the other
  std::vector<BodyShape> ground;

  explicit Listed(const Model& model) : shapes(model.bodies.size()) {
    std::vector<ShapeSet> sets;
    for (const Surface& surface : model.surfaces) {
      std::vector<BodyShape>& own = surface.body == kGround ? ground : shapes[at(surface.body)];
      ShapeSet set{surface.body, surface.name, std::vector<int>(surface.shapes.size())};
      std::iota(set.shapes.begin(), set.shapes.end(), static_cast<int>(own.size()));
      for (const geometry::Shape& shape : surface.shapes) own.push_back({.name = "", .group = "", .shape = shape});
      sets.push_back(std::move(set));
    }
    for (std::size_t i = 0; i < model.events.size(); ++i) add(model, static_cast<int>(i), model.events[i].when, sets);
  }

 private:
  void add(const Model& model, int event, const Condition& condition, const std::vector<ShapeSet>& sets) {
    if (condition.kind == Condition::Kind::kNot) return;
    for (const Condition& part : condition.parts) add(model, event, part, sets);
    if (!condition.parts.empty() || !condition.below) return;
    const unlatch::Quantity quantity = get_quantity(model, condition);
    if (quantity.kind != unlatch::Quantity::Kind::kClearance) return;
    const auto place = [&](int body) { return body == kGround ? model.bodies.size() : at(body); };
    const ShapeSet &a = sets[at(quantity.subject)], &b = sets[at(quantity.other)];
    guards.push_back({event, condition.threshold, place(a.body), place(b.body)});
    pairs.push_back({a, b, {}});
  }
};

UnseenClearances::UnseenClearances(const Scenario& scenario) : UnseenClearances(Listed(scenario.model)) {}

UnseenClearances::UnseenClearances(const Listed& listed)
    : guards_(listed.guards), monitor_(listed.pairs, listed.shapes, listed.ground) {
  for (std::size_t i = 0; i < guards_.size(); ++i) dips_.emplace_back(monitor_, i, guards_[i].a, guards_[i].b);
}

std::span<const UnseenClearance> UnseenClearances::find(const MotionWindow& window) {
  found_.clear();
  const MotionPiece& piece = window.get_present();
  for (std::size_t i = 0; i < guards_.size(); ++i) {
    const Guard& guard = guards_[i];
    if (dips_[i].stays_above(monitor_, piece, guard.threshold)) continue;
    const auto get = [&](const auto& bodies, const auto& accelerations, std::size_t body) {
      return get_moving_body(bodies[body], accelerations[body]);
    };
    const MovingBody from_a = get(piece.start, piece.at_start, guard.a),
                     from_b = get(piece.start, piece.at_start, guard.b);
    const MovingBody to_a = get(piece.end, piece.at_end, guard.a), to_b = get(piece.end, piece.at_end, guard.b);
    const ClearanceMonitor::Reach& reach = monitor_.get_reach(i);
    const double length = calc_length(calc_relative_motion(reach, from_a, from_b),
                                      calc_relative_motion(reach, to_a, to_b), piece.to - piece.from);
    const auto is_below = [&](const MovingBody& a, const MovingBody& b) {
      return monitor_.calc(i, a.at, b.at).least.distance <= guard.threshold;
    };
    const std::optional<Dip> dip = dips_[i].find(
        monitor_, piece, {.length = length, .limit = guard.threshold, .resolution = monitor_.get_resolution(i)});
    // Below it at one end, the condition was seen.
    if (dip && !is_below(from_a, from_b) && !is_below(to_a, to_b))
      found_.push_back({guard.event, dip->time, dip->value});
  }
  return found_;
}

}  // namespace unlatch::hil
