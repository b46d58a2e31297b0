#include "hil/study/sampling/subset.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "hil/scenario/base/normal.h"
#include "hil/scenario/base/philox.h"
#include "unlatch/elementary.h"

namespace unlatch::hil {
namespace {

// Papaioannou et al. (2015), section 4.3: the first spread, and the acceptance at which the correlation of chains
// decays fastest.
constexpr double kFirstSpread = 0.6, kBestAcceptance = 0.44;
constexpr double kLeastSpread = 0.05;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

}  // namespace

SubsetSimulation::SubsetSimulation(const SubsetPlan& plan) : plan_(plan) {
  end_ = step_missing_ = plan_.samples;
  plan_step();
}

std::vector<double> SubsetSimulation::draw_normal(std::int64_t sample) const {
  std::vector<double> u(plan_.dimensions);
  for (std::size_t axis = 0; axis < u.size(); ++axis)
    u[axis] = calc_normal_quantile(draw_unit(plan_.seed, RandomStream::kDraw, static_cast<std::uint64_t>(sample),
                                             static_cast<std::uint32_t>(axis)));
  return u;
}

// Plans the candidates of the step: independent points for level 0, else one for each chain.
void SubsetSimulation::plan_step() {
  candidates_.assign(static_cast<std::size_t>(get_step_size()), {});
  const double keep = std::sqrt(1 - spread_ * spread_);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    candidates_[i].u = draw_normal(step_first_ + static_cast<std::int64_t>(i));
    if (levels_.empty()) continue;
    const std::vector<double>& from = states_[states_.size() - candidates_.size() + i].u;
    for (std::size_t axis = 0; axis < from.size(); ++axis)
      candidates_[i].u[axis] = keep * from[axis] + spread_ * candidates_[i].u[axis];
  }
  if (known_.size() < static_cast<std::size_t>(end_)) {
    known_.resize(static_cast<std::size_t>(end_), false);
    margins_.resize(static_cast<std::size_t>(end_), 0);
  }
  step_missing_ = std::count(known_.begin() + step_first_, known_.begin() + end_, false);
}

std::vector<double> SubsetSimulation::calc_point(std::int64_t sample) const {
  std::vector<double> point(plan_.dimensions);
  if (sample < plan_.samples) {  // the numbers themselves, with the bits of independent sampling
    for (std::size_t axis = 0; axis < point.size(); ++axis)
      point[axis] = draw_unit(plan_.seed, RandomStream::kDraw, static_cast<std::uint64_t>(sample),
                              static_cast<std::uint32_t>(axis));
    return point;
  }
  const std::vector<double>& u = candidates_.at(static_cast<std::size_t>(sample - step_first_)).u;
  for (std::size_t axis = 0; axis < point.size(); ++axis)
    point[axis] = std::clamp(calc_normal_cdf(u[axis]), kLeastUnit, 1 - kLeastUnit);
  return point;
}

void SubsetSimulation::note(std::int64_t sample, double margin) {
  if (sample < 0 || sample >= plan_.get_most_samples()) return;
  const auto at = static_cast<std::size_t>(sample);
  if (known_.size() <= at) {
    known_.resize(at + 1, false);
    margins_.resize(at + 1, 0);
  }
  if (known_[at]) return;
  known_[at] = true;
  margins_[at] = std::isnan(margin) ? -HUGE_VAL : margin;
  if (sample >= step_first_ && sample < end_) --step_missing_;
  while (!finished_ && step_missing_ == 0) end_step();
}

void SubsetSimulation::end_step() {
  const bool independent = levels_.empty();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    State& candidate = candidates_[i];
    candidate.margin = margins_[static_cast<std::size_t>(step_first_) + i];
    const bool accepted = independent || candidate.margin <= levels_.back().threshold;
    accepted_ += accepted ? 1 : 0;
    states_.push_back(accepted ? std::move(candidate) : states_[states_.size() - candidates_.size()]);
  }
  step_first_ = end_;
  if (states_.size() == static_cast<std::size_t>(plan_.samples)) return end_level();
  end_ += plan_.chains;
  plan_step();
}

// Coefficient of variation of a level's probability, with the correlation within its chains: Au and Beck, equations 28
// to 30. A negative estimate of the correlation's contribution counts as zero. Chains that share a seed count as one.
double SubsetSimulation::calc_deviation(double threshold, bool fails, double probability) const {
  if (!(probability > 0)) return kNone;
  const auto chains = static_cast<std::size_t>(plan_.chains);
  const std::size_t count = states_.size(), length = count / chains;
  const double variance = probability * (1 - probability), n = static_cast<double>(count);
  double gamma = 0;
  const auto is_in = [&](std::size_t i) { return fails ? states_[i].margin < 0 : states_[i].margin <= threshold; };
  for (std::size_t lag = 1; !levels_.empty() && variance > 0 && lag < length; ++lag) {
    std::int64_t both = 0;
    for (std::size_t i = 0; i + lag * chains < count; ++i) both += is_in(i) && is_in(i + lag * chains) ? 1 : 0;
    const double pairs = static_cast<double>(count - lag * chains);
    const double correlation = (static_cast<double>(both) / pairs - probability * probability) / variance;
    gamma += 2 * (1 - static_cast<double>(lag) / static_cast<double>(length)) * correlation;
  }
  return std::sqrt((1 - probability) / (probability * n) * (1 + std::max(gamma, 0.0)) * shared_);
}

// Failures on which an estimate may rest: their count alone has a coefficient of variation of 0.3.
std::int64_t SubsetSimulation::get_least_failures() const {
  constexpr std::int64_t kLeast = 10;
  return std::min(kLeast, std::max<std::int64_t>(1, plan_.chains / 2));
}

// The states within the quantile go on, all of those that are equal to it among them. Where these are so many that the
// next level would hardly be narrower, those strictly below the quantile go on, if they are enough; if they fail all,
// nothing lies between them and the failure, and this level is the last.
SubsetSimulation::Next SubsetSimulation::choose_next(const std::vector<double>& sorted) const {
  const auto least = static_cast<std::size_t>(get_least_failures()), chains = static_cast<std::size_t>(plan_.chains);
  const double quantile = sorted[chains - 1];
  const auto below = static_cast<std::size_t>(std::ranges::lower_bound(sorted, quantile) - sorted.begin()),
             within = static_cast<std::size_t>(std::ranges::upper_bound(sorted, quantile) - sorted.begin()),
             failed = static_cast<std::size_t>(std::ranges::lower_bound(sorted, 0.0) - sorted.begin());
  if (failed >= chains) return {.reached = true};
  const bool is_all = below == failed && failed >= least;
  const bool may_go_on = static_cast<int>(levels_.size()) + 1 < plan_.levels;
  if (!may_go_on) return {.reached = is_all && within > chains};
  const Next on{.ends = false, .threshold = quantile, .count = within};
  if (within <= sorted.size() / 2) return on;
  if (is_all) return {.reached = true};
  if (below >= least) return {.ends = false, .threshold = std::nextafter(quantile, -HUGE_VAL), .count = below};
  if (within < sorted.size()) return on;
  return {.reached = levels_.empty() && failed > 0 && below == failed, .tied = true};
}

void SubsetSimulation::end_level() {
  std::vector<std::size_t> order(states_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return states_[a].margin < states_[b].margin; });
  SubsetLevel level;
  level.first = levels_.empty() ? 0 : levels_.back().last;
  level.last = end_;
  level.acceptance = static_cast<double>(accepted_) / static_cast<double>(level.last - level.first);
  level.spread = spread_;
  for (const std::size_t i : order) level.margins.push_back(states_[i].margin);
  const Next next = choose_next(level.margins);
  finished_ = next.ends;
  reached_ = next.reached;
  tied_ = next.tied;
  level.threshold = next.threshold;
  level.failed = std::ranges::lower_bound(level.margins, 0.0) - level.margins.begin();
  const std::size_t count = finished_ ? static_cast<std::size_t>(level.failed) : next.count;
  level.probability = static_cast<double>(count) / static_cast<double>(states_.size());
  level.deviation = calc_deviation(next.threshold, finished_, level.probability);
  levels_.push_back(std::move(level));
  if (!finished_) begin_level(order, next.count);
}

// Every state within the threshold is a seed with the same probability: a systematic sample of them in the order of
// their margins, from a random place. All of them where they are as many as chains.
void SubsetSimulation::begin_level(const std::vector<std::size_t>& order, std::size_t count) {
  const auto chains = static_cast<std::size_t>(plan_.chains);
  const auto place = static_cast<std::size_t>(draw_unit(plan_.seed, RandomStream::kChain, levels_.size(), 0) *
                                              static_cast<double>(count));
  std::vector<State> seeds;
  for (std::size_t i = 0; i < chains; ++i) seeds.push_back(states_[order[(i * count + place) / chains]]);
  states_ = std::move(seeds);
  shared_ = std::max(1.0, static_cast<double>(chains) / static_cast<double>(count));
  const auto k = static_cast<double>(levels_.size());
  spread_ = levels_.size() == 1
                ? kFirstSpread
                : std::clamp(spread_ * elementary::exp((levels_.back().acceptance - kBestAcceptance) / std::sqrt(k)),
                             kLeastSpread, 1.0);
  accepted_ = 0;
  end_ = step_first_ + plan_.chains;
  plan_step();
}

Interval SubsetSimulation::calc_first_bounds() const {
  const SubsetLevel& first = levels_.front();
  return calc_clopper_pearson(first.failed, first.last - first.first);
}

SubsetEstimate SubsetSimulation::calc_estimate() const {
  SubsetEstimate estimate;
  estimate.reached = reached_;
  estimate.tied = tied_;
  estimate.deviation = kNone;
  if (!finished_) return estimate;
  const SubsetLevel& last = levels_.back();
  const bool alone = levels_.size() == 1;
  estimate.decided = reached_ || last.failed >= (alone ? 1 : get_least_failures());
  double product = 1, square = 0;
  for (const SubsetLevel& level : levels_) {
    if (&level == &last && !estimate.decided) break;  // the failures are a part of what it was drawn from
    product *= level.probability;
    square += level.deviation * level.deviation;
  }
  if (estimate.decided && !alone) {
    constexpr double kQuantile = 1.959963984540054;  // of the normal distribution at 0.975
    const double factor = elementary::exp(kQuantile * std::sqrt(calc_log(1 + square)));
    estimate.probability = product;
    estimate.deviation = std::sqrt(square);
    estimate.low = product / factor;
    estimate.high = std::min(1.0, product * factor);
    return estimate;
  }
  if (estimate.decided) {
    estimate.probability = product;
    estimate.deviation = std::sqrt(square);
  }
  // What chains have not found may be elsewhere: without an estimate the independent samples alone bound it.
  const Interval bounds = calc_first_bounds();
  estimate.low = bounds.low;
  estimate.high = bounds.high;
  return estimate;
}

}  // namespace unlatch::hil
