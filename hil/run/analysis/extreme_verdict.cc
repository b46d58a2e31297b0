#include "hil/run/analysis/extreme_verdict.h"

#include <algorithm>
#include <cmath>

#include "hil/run/notices/format.h"
#include "hil/run/notices/resolution.h"

namespace unlatch::hil {
namespace {

using Take = Requirement::Take;

constexpr double kCertain = 1e-6;  // of the value: less is the error of the search

struct Range {
  double low, high;
};

// What the value may be. `is_low`: it is the smallest one, or the negative of that.
Range find_range(const Requirement& requirement, const FoundExtremes& found, bool is_low) {
  const ExtremeBounds::Bound &low = found.least, &high = found.most;
  const Range least = {from_smooth(found.part, low.least), from_smooth(found.part, low.most)};
  const Range most = {from_smooth(found.part, -high.most), from_smooth(found.part, -high.least)};
  if (requirement.take == Take::kPeak) return {std::max(-least.high, most.low), std::max(-least.low, most.high)};
  return is_low ? least : most;
}

// What the value may be where it is known from two knots alone, if it changes there as it has elsewhere; `within`: what
// it may be by the bounds. The same range if no two knots do.
Range find_unsearched_range(const Requirement& requirement, const FoundExtremes& found, bool is_low, Range within) {
  const double low = from_smooth(found.part, std::min(found.least.unsearched, found.least.least));
  const double high = from_smooth(found.part, -std::min(found.most.unsearched, found.most.least));
  if (requirement.take == Take::kPeak) return {within.low, std::max({within.high, -low, high})};
  return is_low ? Range{std::min(within.low, low), within.high} : Range{within.low, std::max(within.high, high)};
}

// A step, as a part of the run's, with which an error comes to what is allowed. Differences that do not fall
// (ExtremeBounds) may fall in proportion to the step at first, until the error is a part of the value; those that fall
// do so with its fourth power at least.
double calc_sufficient_part(double error, double size, double allowed) {
  constexpr double kPart = 0.2, kPower = 4, kSure = 0.7;
  const double first = std::min(1.0, kPart * size / error);
  return kSure * first * std::pow(std::min(1.0, allowed / (error * first)), 1 / kPower);
}

}  // namespace

void judge_extreme(const Requirement& requirement, const FoundExtremes& found, double dt, Verdict& verdict) {
  if (!std::isfinite(found.least.most) && !std::isfinite(found.most.most)) return;
  const bool is_low = requirement.take == Take::kMinimum ||
                      (requirement.take == Take::kPeak ? verdict.value == -found.low
                                                       : requirement.take == Take::kBoth && verdict.value == found.low);
  const Range range = find_range(requirement, found, is_low);
  const ExtremeBounds::Bound& own = is_low ? found.least : found.most;
  verdict.uncertainty = std::max({0.0, verdict.value - range.low, range.high - verdict.value});
  const auto is_at_ticks = [](const ExtremeBounds::Bound& bound) { return bound.unsearched < bound.value; };
  verdict.at_ticks =
      requirement.take == Take::kPeak ? is_at_ticks(found.least) || is_at_ticks(found.most) : is_at_ticks(own);
  const double size = std::max(std::abs(verdict.value), kLimitPart * std::abs(verdict.limit));
  const double low = std::min(verdict.value, range.low), high = std::max(verdict.value, range.high);
  const auto is_within = [&](double limit) { return low < limit && limit < high; };
  const bool may_differ =
      verdict.uncertainty > kCertain * size && (is_within(requirement.least) || is_within(requirement.most));
  const std::string unit = requirement.unit.empty() ? "" : " " + requirement.unit;
  if (verdict.at_ticks && !may_differ) {
    const Range beyond = find_unsearched_range(requirement, found, is_low, {low, high});
    const double limit =
        beyond.low < requirement.least && requirement.least < low ? requirement.least : requirement.most;
    const double reach = limit < low ? beyond.low : beyond.high;
    if (beyond.low < limit && limit < beyond.high && !is_within(limit)) {
      const double step = kRoundedDown * dt * std::min(1.0, (limit - verdict.value) / (reach - verdict.value));
      verdict.unresolved = format(
          "its extreme as sampled at ticks and events: %.6g%s, and %.6g%s between two of them if it changes there "
          "as it does elsewhere; a step of %.3g s would do",
          verdict.value, unit.c_str(), reach, unit.c_str(), step);
      return;
    }
  }
  const double known = kKnown * size;
  if (!may_differ && verdict.uncertainty <= known) return;
  const double allowed = may_differ ? std::min(known, std::abs(verdict.margin)) : known;
  const double time = own.time;
  const double step = kRoundedDown * dt * calc_sufficient_part(verdict.uncertainty, size, allowed);
  verdict.unresolved =
      format("its extreme between steps, at %.6g s: %.6g%s is known to %.2g%s only; a step of %.3g s would do", time,
             verdict.value, unit.c_str(), verdict.uncertainty, unit.c_str(), step);
}

}  // namespace unlatch::hil
