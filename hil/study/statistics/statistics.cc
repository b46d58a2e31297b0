#include "hil/study/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "hil/scenario/base/philox.h"
#include "hil/study/statistics/binomial.h"

namespace unlatch::hil {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> calc_ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  std::vector<double> ranks(values.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t j = i;
    while (j < order.size() && values[order[j]] == values[order[i]]) ++j;
    for (std::size_t k = i; k < j; ++k) ranks[order[k]] = 0.5 * static_cast<double>(i + j - 1);
    i = j;
  }
  return ranks;
}

double calc_mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double calc_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double mean_a = calc_mean(a), mean_b = calc_mean(b);
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : kNaN;
}

bool has_gaps(const std::vector<double>& values) {
  return std::ranges::any_of(values, [](double value) { return std::isnan(value); });
}

}  // namespace

double calc_quantile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return kNaN;
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto k = static_cast<std::size_t>(at);
  if (k + 1 >= sorted.size()) return sorted.back();
  return sorted[k] + (at - static_cast<double>(k)) * (sorted[k + 1] - sorted[k]);
}

// Finds x(r) ≤ quantile < x(s) with P(r ≤ count < s), for the count of values below the quantile.
std::optional<Interval> calc_quantile_interval(const std::vector<double>& sorted, double p, double confidence) {
  const auto n = static_cast<std::int64_t>(sorted.size());
  if (n == 0) return std::nullopt;
  const double tail = 0.5 * (1 - confidence);
  const std::int64_t r = calc_binomial_quantile(tail, n, p),
                     s = calc_binomial_quantile(1 - tail, n, p) + 1;  // ranks from 1
  // P(count < r) ≤ tail: x(r) is below the quantile with the confidence; x(s) above.
  if (r < 1 || s > n) return std::nullopt;
  return Interval{sorted[static_cast<std::size_t>(r - 1)], sorted[static_cast<std::size_t>(s - 1)]};
}

Interval calc_clopper_pearson(std::int64_t hits, std::int64_t trials, double confidence) {
  if (trials <= 0) return {0, 1};
  const double tail = 0.5 * (1 - confidence);
  return {calc_lower_bound(hits, trials, tail), calc_upper_bound(hits, trials, tail)};
}

std::int64_t calc_wilks_trials(double coverage, double confidence) {
  return static_cast<std::int64_t>(std::ceil(std::log1p(-confidence) / std::log(coverage)));
}

// Greatest rank r with P(fewer than r of the trials are above the quantile) ≤ 1 − confidence.
std::int64_t calc_wilks_rank(std::int64_t trials, double coverage, double confidence) {
  return trials <= 0 ? 0 : calc_binomial_quantile(1 - confidence, trials, 1 - coverage);
}

double calc_spearman(const std::vector<double>& x_in, const std::vector<double>& y_in) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < x_in.size(); ++i) {
    if (std::isnan(x_in[i]) || std::isnan(y_in[i])) continue;
    x.push_back(x_in[i]);
    y.push_back(y_in[i]);
  }
  return x.size() < 3 ? kNaN : calc_correlation(calc_ranks(x), calc_ranks(y));
}

void RankedVariables::add(const std::vector<double>& x, bool category) {
  std::vector<double> present;
  for (const double value : x)
    if (!std::isnan(value)) present.push_back(value);
  const std::vector<double> ranks = calc_ranks(present);
  Ranks& own = variables_.emplace_back();
  own.gaps = present.size() < x.size();
  own.centred.reserve(x.size());
  const double mean = present.empty() ? 0 : calc_mean(present);  // of large values little would be left of the squares
  for (const double value : x) own.centred.push_back(value - mean);
  own.twice.reserve(x.size());
  std::size_t next = 0;
  for (const double value : x)
    own.twice.push_back(std::isnan(value) ? kNoRank : static_cast<std::uint32_t>(2 * ranks[next++]));
  if (!category) return;
  std::ranges::sort(present);
  present.erase(std::unique(present.begin(), present.end()), present.end());
  own.group_count = present.size();
  for (const double value : x)
    own.groups.push_back(std::isnan(value)
                             ? kNoGroup
                             : static_cast<std::size_t>(std::ranges::lower_bound(present, value) - present.begin()));
}

// Ranks of a part of the samples follow from the ranks of all.
std::vector<double> RankedVariables::calc_spearman(const std::vector<double>& y) const {
  const bool gaps = y.size() < 3 || has_gaps(y);
  const std::vector<double> ranks = gaps ? std::vector<double>() : calc_ranks(y);
  std::vector<double> all, own;
  for (const Ranks& variable : variables_) {
    if (variable.group_count > 0) {
      all.push_back(kNaN);
      continue;
    }
    own.clear();
    for (const std::uint32_t twice : variable.twice) own.push_back(twice == kNoRank ? kNaN : 0.5 * twice);
    all.push_back(gaps || variable.gaps ? hil::calc_spearman(own, y) : calc_correlation(own, ranks));
  }
  return all;
}

namespace {

// Sums over points (x, y) that come one by one, and without some of them again.
struct Moments {
  double count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  void add(const Moments& other, double sign) {
    count += sign * other.count;
    x += sign * other.x;
    y += sign * other.y;
    xx += sign * other.xx;
    xy += sign * other.xy;
    yy += sign * other.yy;
  }
  [[nodiscard]] double calc_spread() const { return count > 0 ? yy - y * y / count : 0; }
};
Moments make_moments(double x, double y) { return {1, x, y, x * x, x * y, y * y}; }

// What a straight line through the points of a bin leaves of their spread, and how many numbers it has: a bin of one
// value of x, or of two points, has its mean alone.
struct Rest {
  double spread = 0, numbers = 0;
};
Rest calc_rest(const Moments& bin) {
  if (!(bin.count > 0)) return {};
  const double mean_only = bin.calc_spread(), width = bin.xx - bin.x * bin.x / bin.count;
  if (bin.count < 3 || !(width > 1e-12 * bin.xx)) return {mean_only, 1};
  const double slope_part = bin.xy - bin.x * bin.y / bin.count;
  return {std::max(0.0, mean_only - slope_part * slope_part / width), 2};
}

constexpr std::size_t kParts = 20;    // of the jackknife
constexpr double kStudent19 = 2.093;  // 97.5 % of Student's t with 19 degrees of freedom

// ε², and by how much η² is greater: the part that the lines explain of what is left to chance.
struct Explained {
  double index = kNaN, allowance = 0;
};
Explained calc_epsilon_squared(const std::vector<Moments>& bins) {
  Moments all;
  double within = 0, used = 0;
  for (const Moments& bin : bins) {
    all.add(bin, 1);
    const Rest rest = calc_rest(bin);
    within += rest.spread;
    used += rest.numbers;
  }
  const double total = all.calc_spread();
  if (!(total > 0) || used < 2 || all.count <= used) return {};
  const double index = 1 - (within / (all.count - used)) / (total / (all.count - 1));
  return {index, 1 - within / total - index};
}

// `parts`: moments by part of the samples and bin.
FirstOrder calc_first_order(const std::vector<std::vector<Moments>>& parts, Evenness evenness) {
  std::vector<Moments> all(parts[0].size());
  for (const std::vector<Moments>& part : parts)
    for (std::size_t bin = 0; bin < all.size(); ++bin) all[bin].add(part[bin], 1);
  const auto [index, allowance] = calc_epsilon_squared(all);
  double mean = 0, square = 0;
  std::vector<double> without;
  for (const std::vector<Moments>& part : parts) {
    std::vector<Moments> others = all;
    for (std::size_t bin = 0; bin < all.size(); ++bin) others[bin].add(part[bin], -1);
    without.push_back(calc_epsilon_squared(others).index);
    mean += without.back() / static_cast<double>(parts.size());
  }
  for (const double one : without) square += (one - mean) * (one - mean);
  const auto n = static_cast<double>(parts.size());
  const double half = kStudent19 * std::sqrt(square * (n - 1) / n);
  if (std::isnan(index) || std::isnan(half)) return {index, {kNaN, kNaN}};
  const double high = index + half + (evenness == Evenness::kEven ? allowance : 0);
  return {std::clamp(index, 0.0, 1.0), {std::clamp(index - half, 0.0, 1.0), std::clamp(high, 0.0, 1.0)}};
}

// The same with the mean of each group.
FirstOrder calc_group_order(const std::vector<std::size_t>& groups, std::size_t count, const std::vector<double>& y,
                            double mean, Evenness evenness) {
  std::vector<std::vector<Moments>> parts(kParts, std::vector<Moments>(count));
  for (std::size_t i = 0; i < y.size(); ++i)
    if (!std::isnan(y[i]) && groups[i] < count) parts[i % kParts][groups[i]].add(make_moments(0, y[i] - mean), 1);
  return calc_first_order(parts, evenness);
}

}  // namespace

FirstOrders RankedVariables::calc_first_orders(const std::vector<double>& y, Evenness evenness) const {
  FirstOrders out;
  std::vector<double> present;
  for (const double value : y)
    if (!std::isnan(value)) present.push_back(value);
  const double mean = present.empty() ? 0 : calc_mean(present), n = static_cast<double>(present.size());
  constexpr double kLeastBins = 3, kMostBins = 33;
  out.bins = static_cast<std::size_t>(std::clamp(std::floor(std::sqrt(n) / 3), kLeastBins, kMostBins));
  const auto bins = static_cast<double>(out.bins);
  if (n < 2 * kParts) {
    out.of_inputs.assign(variables_.size(), {kNaN, {kNaN, kNaN}});
    out.significant = kNaN;
    return out;
  }
  // of the part that the lines explain, which is beta distributed where there is no influence
  const double numbers = 2 * bins;
  const double chance = calc_beta_quantile(0.5 * (numbers - 1), 0.5 * (n - numbers), kConfidence);
  out.significant = 1 - (1 - chance) * (n - 1) / (n - numbers);
  for (const Ranks& variable : variables_) {
    if (variable.group_count > 0) {
      out.of_inputs.push_back(variable.group_count > 2 * out.bins
                                  ? FirstOrder{kNaN, {kNaN, kNaN}}
                                  : calc_group_order(variable.groups, variable.group_count, y, mean, evenness));
      continue;
    }
    std::vector<std::vector<Moments>> parts(kParts, std::vector<Moments>(out.bins));
    const auto count = static_cast<double>(variable.twice.size());
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (std::isnan(y[i]) || variable.twice[i] == kNoRank) continue;
      const auto bin = static_cast<std::size_t>(0.5 * variable.twice[i] / count * bins);
      parts[i % kParts][std::min(bin, out.bins - 1)].add(make_moments(variable.centred[i], y[i] - mean), 1);
    }
    out.of_inputs.push_back(calc_first_order(parts, evenness));
  }
  return out;
}

MorrisEffect calc_morris(const std::vector<double>& effects) {
  MorrisEffect effect;
  const auto n = static_cast<double>(effects.size());
  for (const double e : effects) {
    effect.mean_size += std::abs(e) / n;
    effect.mean += e / n;
  }
  for (const double e : effects) effect.deviation += (e - effect.mean) * (e - effect.mean);
  effect.deviation = n > 1 ? std::sqrt(effect.deviation / (n - 1)) : 0;
  return effect;
}

namespace {

// Sums over rows, to which both indices of an axis belong. Outputs are centred: the product of the means would cancel
// badly.
struct RowSums {
  double rows = 0, sum = 0, square = 0;  // of a and b
  std::vector<double> product, difference, jansen;

  explicit RowSums(std::size_t axes) : product(axes), difference(axes), jansen(axes) {}
  void add(const RowSums& other, double sign) {
    rows += sign * other.rows;
    sum += sign * other.sum;
    square += sign * other.square;
    for (std::size_t axis = 0; axis < product.size(); ++axis) {
      product[axis] += sign * other.product[axis];
      difference[axis] += sign * other.difference[axis];
      jansen[axis] += sign * other.jansen[axis];
    }
  }
  [[nodiscard]] double calc_variance() const {
    const double mean = sum / (2 * rows);
    return square / (2 * rows) - mean * mean;
  }
  [[nodiscard]] double calc_first(std::size_t axis) const {
    return (product[axis] - sum / (2 * rows) * difference[axis]) / rows / calc_variance();
  }
  [[nodiscard]] double calc_total(std::size_t axis) const { return jansen[axis] / (2 * rows) / calc_variance(); }
};

// `without`: without each row. `positive`: an estimate that is above 0 and skewed upwards, whose logarithm has the
// interval of the jackknife, too.
std::optional<Interval> calc_index_interval(double index, std::vector<double> resampled,
                                            const std::vector<double>& without, bool positive) {
  const bool finite = std::isfinite(index) &&
                      std::ranges::all_of(resampled, [](double x) { return std::isfinite(x); }) &&
                      std::ranges::all_of(without, [](double x) { return std::isfinite(x); });
  if (!finite) return std::nullopt;
  constexpr double kTail = 0.5 * (1 - kConfidence);
  std::sort(resampled.begin(), resampled.end());
  const auto n = static_cast<double>(without.size());
  const double mean = calc_mean(without);
  double square = 0;
  for (const double one : without) square += (one - mean) * (one - mean);
  const double half = calc_student_quantile(n - 1, 1 - kTail) * std::sqrt(square * (n - 1) / n);
  const double above = positive && index > 0 ? index * std::exp(half / index) : index + half;
  return Interval{std::clamp(std::min(calc_quantile(resampled, kTail), index - half), 0.0, 1.0),
                  std::clamp(std::max(calc_quantile(resampled, 1 - kTail), above), 0.0, 1.0)};
}

}  // namespace

std::vector<SobolIndex> calc_sobol_indices(const std::vector<double>& a, const std::vector<double>& b,
                                           std::span<const std::vector<double>> ab, std::uint64_t seed) {
  const std::size_t n = a.size(), axes = ab.size();
  double mean = 0;
  for (std::size_t i = 0; i < n; ++i) mean += (a[i] + b[i]) / (2 * static_cast<double>(n));
  std::vector<RowSums> rows(n, RowSums(axes));
  RowSums all(axes);
  for (std::size_t i = 0; i < n; ++i) {
    const double of_a = a[i] - mean, of_b = b[i] - mean;
    rows[i].rows = 1;
    rows[i].sum = of_a + of_b;
    rows[i].square = of_a * of_a + of_b * of_b;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const double step = ab[axis][i] - a[i];
      rows[i].product[axis] = of_b * step;
      rows[i].difference[axis] = step;
      rows[i].jansen[axis] = step * step;
    }
    all.add(rows[i], 1);
  }
  std::vector<SobolIndex> indices;
  for (std::size_t axis = 0; axis < axes; ++axis) indices.push_back({all.calc_first(axis), all.calc_total(axis)});
  const auto cut = [](std::vector<SobolIndex>& list) {
    for (SobolIndex& index : list) {  // NaN stays
      index.first = std::clamp(index.first, 0.0, 1.0);
      index.total = std::clamp(index.total, 0.0, 1.0);
    }
  };
  if (n < kLeastSobolRows) {
    cut(indices);
    return indices;
  }
  std::vector<std::vector<double>> firsts(axes), totals(axes), firsts_without(axes), totals_without(axes);
  const auto keep = [axes](const RowSums& sums, auto& first, auto& total) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      first[axis].push_back(sums.calc_first(axis));
      total[axis].push_back(sums.calc_total(axis));
    }
  };
  constexpr std::uint32_t kResamples = 1000;
  for (std::uint32_t k = 0; k < kResamples; ++k) {
    RowSums sums(axes);
    for (std::size_t i = 0; i < n; ++i)
      sums.add(
          rows[static_cast<std::size_t>(draw_unit(seed, RandomStream::kResampling, i, k) * static_cast<double>(n))], 1);
    keep(sums, firsts, totals);
  }
  for (const RowSums& row : rows) {
    RowSums others = all;
    others.add(row, -1);
    keep(others, firsts_without, totals_without);
  }
  for (std::size_t axis = 0; axis < axes; ++axis) {
    SobolIndex& index = indices[axis];
    index.first_interval = calc_index_interval(index.first, std::move(firsts[axis]), firsts_without[axis], false);
    index.total_interval = calc_index_interval(index.total, std::move(totals[axis]), totals_without[axis], true);
  }
  cut(indices);
  return indices;
}

}  // namespace unlatch::hil
