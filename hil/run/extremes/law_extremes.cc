#include "hil/run/extremes/law_extremes.h"

#include <algorithm>
#include <cmath>

#include "hil/scenario/base/index.h"

namespace unlatch::hil {
namespace {

// What the values of a law at the latest knots say of one interval between two of them.
struct LawSpread {
  double lower = 0, upper = 0;  // at its ends
  double beyond = 0;            // how far an extreme within may be beyond these
  double error = 0;             // how far the polynomial through the knots differs from that through one knot less
};

// `times`, `values`: of the latest knots of a smooth curve, two or more; `first`: the knot at which the interval
// begins.
LawSpread calc_spread(std::span<const double> times, std::span<const double> values, std::size_t first) {
  const double a = values[first], b = values[first + 1], h = times[first + 1] - times[first];
  LawSpread spread{.lower = std::min(a, b), .upper = std::max(a, b)};
  if (values.size() == 2) {  // nothing says how it bends
    spread.beyond = spread.error = std::abs(b - a);
    return spread;
  }
  for (std::size_t k = 0; k + 2 < values.size(); ++k) {
    const double slope = (values[k + 1] - values[k]) / (times[k + 1] - times[k]);
    const double next = (values[k + 2] - values[k + 1]) / (times[k + 2] - times[k + 1]);
    const double bend = 2 * (next - slope) / (times[k + 2] - times[k]);
    spread.beyond = std::max(spread.beyond, std::abs(bend) * h * h / 4);  // a parabola's, twice
  }
  const double middle = times[first] + 0.5 * h;
  const std::size_t rest = values.size() - 1, from = first == 0 ? 0 : 1;  // without the knot that is farther away
  spread.error = std::abs(interpolate(times, values, middle) -
                          interpolate(times.subspan(from, rest), values.subspan(from, rest), middle));
  return spread;
}

}  // namespace

LawExtremes::LawExtremes(const Model& model, const Plan& plan, int quantity, Sides sides)
    : model_(model),
      plan_(plan),
      quantity_(quantity),
      sides_(sides),
      curve_(model, plan, model.quantities[at(quantity)].subject) {}

void LawExtremes::take(double time, double value) {
  low_.found.take(time, value);
  high_.found.take(time, -value);
}

void LawExtremes::add_knot(const MotionKnot& knot, std::span<const double> commands, bool begins) {
  curve_.add(knot.time, knot.quantities, commands, begins);
  const double value = knot.quantities[at(quantity_)];
  std::ranges::rotate(times_, times_.begin() + 1);
  std::ranges::rotate(values_, values_.begin() + 1);
  times_.back() = knot.time;
  values_.back() = value;
  take(knot.time, value);
}

void LawExtremes::add(const MotionKnot& from, const MotionKnot& to, std::span<const double> commands, bool begins,
                      const FinerSource& finer) {
  // What changes at events alone, or is straight between them, may begin anew where the rest goes on smoothly.
  const bool anew = !begins && curve_.begins_anew(from.quantities, to.time, to.quantities);
  if (anew) search(End::kEnds, finer);
  if (begins || anew) add_knot(from, commands, true);
  add_knot(to, commands, false);
  search(End::kGoesOn, finer);
}

// Searches the interval before the latest one, or where the curve ends the latest.
void LawExtremes::search(End end, const FinerSource& finer) {
  constexpr double kGain = 1e-3;  // of the value
  const bool ends = end == End::kEnds;
  const auto knots = static_cast<std::size_t>(curve_.count_knots());
  if (knots < (ends ? 2 : 3)) return;
  const LawSpread spread =
      calc_spread(std::span(times_).last(knots), std::span(values_).last(knots), knots - (ends ? 2 : 3));
  const LawCurve::Span span = ends ? curve_.get_latest_span() : curve_.get_span_before();
  const auto look = [&](bool is_low, Side& side) {
    Smallest& own = side.found;
    Smallest tried = own;
    Smallest *const low = is_low ? &tried : nullptr, *const high = is_low ? nullptr : &tried;
    ends ? curve_.finish(low, high) : curve_.search(low, high);
    const double room = kGain * std::abs(tried.get_value());
    const double beyond = (is_low ? spread.lower : -spread.upper) - spread.beyond;
    const bool may_be_beyond = spread.error > room && beyond < own.get_value();
    const double gain = own.get_value() - tried.get_value();
    Smallest found = own;
    if ((gain > room || may_be_beyond) && refine(span, is_low, finer, found)) {
      if (gain > room || found.get_value() < own.get_value())
        side.error = std::abs(found.get_value() - tried.get_value()) / FinerSteps::kParts;
      own = found;
      return;
    }
    if (gain > 0) side.error = gain > room ? gain : 0;
    if (may_be_beyond && knots == 2) side.unsearched = std::min(side.unsearched, beyond);
    own = tried;
  };
  if (sides_.low) look(true, low_);
  if (sides_.high) look(false, high_);
}

// False if the step is not taken again.
bool LawExtremes::refine(LawCurve::Span span, bool is_low, const FinerSource& finer, Smallest& found) {
  const FinerSteps::Again again = finer.take(span.from, span.to);
  if (again.knots.empty()) return false;
  if (!finer_curve_) finer_curve_.emplace(model_, plan_, model_.quantities[at(quantity_)].subject);
  LawCurve& law = *finer_curve_;
  Smallest *const low = is_low ? &found : nullptr, *const high = is_low ? nullptr : &found;
  const auto is_within = [&span](LawCurve::Span own) {
    return own.get_middle() > span.from && own.get_middle() < span.to;
  };
  const auto finish = [&] {
    if (is_within(law.get_latest_span())) law.finish(low, high);
  };
  for (const std::unique_ptr<FinerKnot>& own : again.knots) {
    if (own->begins && own != again.knots.front()) finish();
    law.add(own->knot.time, own->knot.quantities, again.commands, own->begins);
    if (own->knot.time >= span.from && own->knot.time <= span.to) {
      const double value = own->knot.quantities[at(quantity_)];
      found.take(own->knot.time, is_low ? value : -value);
    }
    if (!own->begins && law.count_knots() > 2 && is_within(law.get_span_before())) law.search(low, high);
  }
  finish();
  return true;
}

}  // namespace unlatch::hil
