// Statistics of campaigns. Quantiles: linear interpolation of order statistics, NumPy's default (type 7 of Hyndman and
// Fan 1996). Intervals without an assumption on the distribution: order statistics whose ranks a binomial count gives
// (Conover 1999). Probabilities: Clopper and Pearson 1934. Tolerance limits: Wilks 1941.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace unlatch::hil {

struct Interval {
  double low = 0, high = 0;
};

inline constexpr double kConfidence = 0.95;  // confidence of all intervals

// Quantile of sorted values; p in [0, 1]. NaN for no values.
double calc_quantile(const std::vector<double>& sorted, double p);
// Interval of a quantile; nothing if there are too few values for the confidence.
std::optional<Interval> calc_quantile_interval(const std::vector<double>& sorted, double p,
                                               double confidence = kConfidence);

// Two-sided bounds of a probability from `hits` of `trials`.
Interval calc_clopper_pearson(std::int64_t hits, std::int64_t trials, double confidence = kConfidence);

// Least number of samples whose greatest value is above a part `coverage` of the population with this confidence; and
// the rank from the top, 1 for the greatest, that `trials` allow; 0: too few.
std::int64_t calc_wilks_trials(double coverage, double confidence = kConfidence);
std::int64_t calc_wilks_rank(std::int64_t trials, double coverage, double confidence = kConfidence);

// Rank correlation, ties at their mean rank; pairs with a NaN left out. NaN if one variable is constant.
double calc_spearman(const std::vector<double>& x, const std::vector<double>& y);

// First-order index of an input from given samples: the part of an output's variance that the mean at each value of
// this input explains, whatever the dependence is, even or odd. The sum over independent inputs is 1 where they do not
// interact.
struct FirstOrder {
  double index = 0;   // within 0 … 1; NaN: too few values, or one of both is constant
  Interval interval;  // 95 %
};
// Samples that are more even than chance (a Sobol' sequence) leave less of the other inputs in the means of the bins
// than ε² allows for, down to nothing: an interval then reaches to the index without that allowance, η².
enum class Evenness { kRandom, kEven };

// First-order indices of one output.
struct FirstOrders {
  std::vector<FirstOrder> of_inputs;
  double significant = 0;  // an input without influence stays below this with 95 % probability
  std::size_t bins = 0;
};

// The same of one variable with each of several.
class RankedVariables {
 public:
  // `category`: the values are numbers of things in no order, so that there is no rank correlation; each value is a bin
  // of its own, as long as there are not more than 2 bins.
  void add(const std::vector<double>& x, bool category = false);
  [[nodiscard]] std::vector<double> calc_spearman(const std::vector<double>& y) const;
  // The values are sorted into √N/3 bins (3 to 33) of equal numbers by their ranks; equal values share a bin. Each bin
  // has a straight line of least squares, all of them p = 2 bins numbers; of one value of x the mean alone.
  // ε² = 1 − (rest/(N − p))/(total/(N − 1)) (Kelley 1935), which is unbiased where there is no influence and for a
  // line, and too small by index/bins⁴ for a parabola over a uniform input. Intervals: jackknife over 20 interleaved
  // parts of the samples, Student's t, within 0 … 1. The significance is that of the F test, exact for normal outputs.
  [[nodiscard]] FirstOrders calc_first_orders(const std::vector<double>& y,
                                              Evenness evenness = Evenness::kRandom) const;

 private:
  struct Ranks {
    std::vector<std::uint32_t> twice;  // each rank, which is then whole; kNoRank of a NaN
    std::vector<double> centred;       // the values less their mean
    bool gaps = false;
    std::vector<std::size_t> groups{};  // of a category: the bin of each sample, kNoGroup of a NaN
    std::size_t group_count = 0;        // 0: no category
  };
  static constexpr std::uint32_t kNoRank = 0xffffffff;
  static constexpr std::size_t kNoGroup = static_cast<std::size_t>(-1);
  std::vector<Ranks> variables_;
};

// Elementary effects of an axis over trajectories: mean of the sizes, standard deviation (Morris 1991, Campolongo
// 2007).
struct MorrisEffect {
  double mean_size = 0, mean = 0, deviation = 0;
};
MorrisEffect calc_morris(const std::vector<double>& effects);

// Indices of one axis from outputs at A, B and A with the axis of B: Saltelli 2010 (first order), Jansen 1999 (total).
// All axes at once: they share the resampled rows. The interval has both that of 1,000 resamples of the rows (Philox),
// percentiles, and that of the jackknife over the rows with Student's t: each alone is too narrow at one end where an
// index is skewed; a total's is that of its logarithm upwards. Both are cut to 0 … 1, where indices are. Below
// kLeastSobolRows no method of these covers as it says.
inline constexpr std::size_t kLeastSobolRows = 100;
struct SobolIndex {
  double first = 0, total = 0;
  std::optional<Interval> first_interval{}, total_interval{};  // 95 %; nothing: too few rows, or a constant
};
std::vector<SobolIndex> calc_sobol_indices(const std::vector<double>& a, const std::vector<double>& b,
                                           std::span<const std::vector<double>> ab, std::uint64_t seed);

}  // namespace unlatch::hil
