#include "hil/run/extremes/law_extremes.h"

#include <algorithm>
#include <memory>

#include "hil/scenario/base/index.h"

namespace unlatch::hil {
LawExtremes::LawExtremes(const Model& model, const Plan& plan, int quantity, Sides sides)
    : model_(model),
      plan_(plan),
      quantity_(quantity),
      sides_(sides),
      curve_(model, plan, model.quantities[at(quantity)].subject) {}

void LawExtremes::take(double time, double value) {
  low_.take(time, value);
  high_.take(time, -value);
}

void LawExtremes::add_knot(const MotionKnot& knot, std::span<const double> commands, bool begins) {
  curve_.add(knot.time, knot.quantities, commands, begins);
  take(knot.time, knot.quantities[at(quantity_)]);
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
  const bool ends = end == End::kEnds;
  if (curve_.count_knots() < (ends ? 2 : 3)) return;
  const LawCurve::Span span = ends ? curve_.get_latest_span() : curve_.get_span_before();
  const auto look = [&](LawCurve::Extreme extreme, LawCurve::Found& own) {
    LawCurve::Found here;
    here.value = own.value;
    ends ? curve_.finish(extreme, here) : curve_.search(extreme, here);
    const double least = std::min(here.least, here.unsearched), found = here.value.get_value();
    const double known = own.value.get_value(), room = curve_.calc_room(found);
    const bool matters =
        here.is_unknown || (least < known && found - least > room) || (found < known && here.most - found > room);
    if (matters) refine(span, extreme, finer, own.value, here);
    own.value = here.value;
    own.least = std::min(own.least, here.least);
    own.most = std::min(own.most, here.most);
    own.unsearched = std::min(own.unsearched, here.unsearched);
  };
  if (sides_.low) look(LawCurve::Extreme::kLow, low_);
  if (sides_.high) look(LawCurve::Extreme::kHigh, high_);
}

// What the shorter steps show instead of `found`, where the step is taken again.
void LawExtremes::refine(LawCurve::Span span, LawCurve::Extreme extreme, const FinerSource& finer,
                         const Smallest& known, LawCurve::Found& found) {
  const FinerSteps::Again again = finer.take(span.from, span.to);
  if (again.knots.empty()) return;
  if (!finer_curve_) finer_curve_.emplace(model_, plan_, model_.quantities[at(quantity_)].subject);
  LawCurve& law = *finer_curve_;
  law.follow(curve_);
  const auto add = [&](const FinerKnot& own) {
    law.add(own.knot.time, own.knot.quantities, again.commands, own.begins);
  };
  // How what it reads changes there, before any pair of knots is judged by that.
  for (const std::unique_ptr<FinerKnot>& own : again.knots) add(*own);
  found = LawCurve::Found();
  found.value = known;
  const auto is_within = [&span](LawCurve::Span own) {
    return own.get_middle() > span.from && own.get_middle() < span.to;
  };
  const auto finish = [&] {
    if (is_within(law.get_latest_span())) law.finish(extreme, found);
  };
  const auto take = [&](const FinerKnot& own) {
    if (own.knot.time < span.from || own.knot.time > span.to) return;
    const double value = own.knot.quantities[at(quantity_)];
    found.take(own.knot.time, extreme == LawCurve::Extreme::kLow ? value : -value);
  };
  const FinerKnot* before = nullptr;
  for (const std::unique_ptr<FinerKnot>& own : again.knots) {
    if (own->begins && before != nullptr) finish();
    add(*own);
    // At the ends there may be knots on the other side of a jump, of other pieces.
    if (!own->begins && is_within(law.get_latest_span())) {
      take(*before);
      take(*own);
    }
    if (!own->begins && law.count_knots() > 2 && is_within(law.get_span_before())) law.search(extreme, found);
    before = own.get();
  }
  finish();
  curve_.learn_from(law);
}

}  // namespace unlatch::hil
