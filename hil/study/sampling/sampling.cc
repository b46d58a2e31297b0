#include "hil/study/sampling/sampling.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "hil/scenario/base/philox.h"
#include "hil/study/sampling/sobol.h"

namespace unlatch::hil {
namespace {

constexpr double kMedian = 0.5;

double draw(const SamplingPlan& plan, std::int64_t sample, std::size_t axis) {
  return draw_unit(plan.seed, RandomStream::kDraw, static_cast<std::uint64_t>(sample),
                   static_cast<std::uint32_t>(axis));
}

// Permutation of 0 … size − 1 for each axis.
std::uint64_t permute(std::uint64_t seed, std::uint32_t axis, std::uint64_t size, std::uint64_t at) {
  const int half = std::max(1, (static_cast<int>(std::bit_width(size - 1)) + 1) / 2);
  const std::uint64_t mask = (std::uint64_t{1} << half) - 1;
  constexpr std::uint32_t kRounds = 6;
  do {  // the network permutes 4^half numbers; repeating it leads back to a number below `size`
    std::uint64_t left = at >> half, right = at & mask;
    for (std::uint32_t round = 0; round < kRounds; ++round) {
      const std::uint64_t word = draw_word(seed, RandomStream::kPermutation, right, axis * kRounds + round);
      const std::uint64_t next = left ^ (word & mask);
      left = right;
      right = next;
    }
    at = left << half | right;
  } while (at >= size);
  return at;
}

double calc_latin(const SamplingPlan& plan, std::int64_t sample, std::size_t axis) {
  const auto size = static_cast<std::uint64_t>(plan.samples);
  const std::uint64_t part =
      permute(plan.seed, static_cast<std::uint32_t>(axis), size, static_cast<std::uint64_t>(sample));
  const double u = (static_cast<double>(part) + draw(plan, sample, axis)) / static_cast<double>(size);
  return std::clamp(u, kLeastUnit, 1 - kLeastUnit);
}

// Middle of level k of n equally probable ones.
double calc_level(std::int64_t k, int levels) { return (static_cast<double>(k) + 0.5) / levels; }

std::vector<double> calc_grid(const SamplingPlan& plan, std::int64_t sample) {
  std::vector<double> point(plan.dimensions);
  for (std::size_t axis = plan.dimensions; axis-- > 0;) {
    point[axis] = calc_level(sample % plan.levels[axis], plan.levels[axis]);
    sample /= plan.levels[axis];
  }
  return point;
}

std::vector<double> calc_one_at_a_time(const SamplingPlan& plan, std::int64_t sample) {
  std::vector<double> point(plan.dimensions, kMedian);
  std::int64_t at = sample - 1;
  for (std::size_t axis = 0; axis < plan.dimensions && at >= 0; ++axis) {
    if (at < plan.levels[axis]) point[axis] = calc_level(at, plan.levels[axis]);
    at -= plan.levels[axis];
  }
  return point;
}

// Levels 0, 1/3, 2/3, 1 of the middle 98 % of each axis, whose ends may be infinite.
double to_morris_probability(double level) { return 0.01 + 0.98 * level; }

std::vector<double> calc_morris(const SamplingPlan& plan, std::int64_t sample) {
  const std::int64_t block = get_block(plan), trajectory = sample / block;
  std::vector<double> point(plan.dimensions);
  for (std::size_t axis = 0; axis < plan.dimensions; ++axis)  // the end from which its one step begins
    point[axis] = (draw_word(plan.seed, RandomStream::kDraw, static_cast<std::uint64_t>(trajectory),
                             static_cast<std::uint32_t>(axis)) &
                   1) != 0
                      ? 1.0 / 3
                      : 0;
  std::vector<bool> moved(plan.dimensions, false);
  for (std::size_t k = 1; k <= static_cast<std::size_t>(sample % block); ++k)
    moved[get_morris_step(plan, trajectory, k).axis] = true;
  for (std::size_t axis = 0; axis < plan.dimensions; ++axis) {
    const bool downward = (draw_word(plan.seed, RandomStream::kDraw, static_cast<std::uint64_t>(trajectory),
                                     static_cast<std::uint32_t>(axis)) &
                           2) != 0;
    const double level = point[axis] + (moved[axis] != downward ? kMorrisStep : 0);
    point[axis] = to_morris_probability(level);
  }
  return point;
}

std::vector<double> calc_saltelli(const SamplingPlan& plan, std::int64_t sample) {
  const std::int64_t block = get_block(plan), row = sample / block, k = sample % block;
  std::vector<double> point(plan.dimensions);
  for (std::size_t axis = 0; axis < plan.dimensions; ++axis) {
    const bool of_b = k == 1 || k == static_cast<std::int64_t>(axis) + 2;
    point[axis] = draw(plan, row, axis + (of_b ? plan.dimensions : 0));
  }
  return point;
}

}  // namespace

const std::vector<std::string> kSamplingNames{"random", "latin-hypercube", "sobol", "grid",  "one-at-a-time",
                                              "morris", "saltelli",        "csv",   "subset"};

SampleBasis get_basis(Sampling sampling) {
  switch (sampling) {
    case Sampling::kRandom:
    case Sampling::kSubset:
      return SampleBasis::kIndependent;
    case Sampling::kLatinHypercube:
      return SampleBasis::kStratified;
    case Sampling::kSobol:
      return SampleBasis::kQuasiRandom;
    case Sampling::kSaltelli:
      return SampleBasis::kBaseRows;
    case Sampling::kCsv:
      return SampleBasis::kTable;
    case Sampling::kGrid:
    case Sampling::kOneAtATime:
    case Sampling::kMorris:
      break;
  }
  return SampleBasis::kChosen;
}

std::string describe_basis(Sampling sampling) {
  const std::string& name = kSamplingNames[static_cast<std::size_t>(sampling)];
  switch (get_basis(sampling)) {
    case SampleBasis::kIndependent:
      return "";
    case SampleBasis::kStratified:
      return "samples of a latin hypercube are not independent: bounds, intervals and tolerance limits are those of "
             "independent ones, as a rule cautious here, but not guaranteed";
    case SampleBasis::kQuasiRandom:
      return "samples of a Sobol' sequence are not independent: bounds, intervals and tolerance limits are those of "
             "independent ones, mostly cautious here, but not guaranteed";
    case SampleBasis::kBaseRows:
      return "probabilities, quantiles and tolerance limits are of the first two samples of each block alone, which "
             "are independent draws; the others repeat their values";
    case SampleBasis::kTable:
      return "bounds, intervals and tolerance limits hold if the rows of the table are independent draws";
    case SampleBasis::kChosen:
      break;
  }
  return "samples of " + name +
         " are chosen, not drawn from the distributions: they have no probabilities, quantiles or tolerance limits; "
         "take those from a random campaign";
}

MorrisStep get_morris_step(const SamplingPlan& plan, std::int64_t trajectory, std::size_t k) {
  const std::uint64_t row = static_cast<std::uint64_t>(trajectory);
  // Permutation of the axes for each trajectory.
  const auto axis =
      static_cast<std::size_t>(permute(plan.seed ^ (row + 1) * 0x9E3779B97F4A7C15u, 0xFFFFFF, plan.dimensions, k - 1));
  const bool downward = (draw_word(plan.seed, RandomStream::kDraw, row, static_cast<std::uint32_t>(axis)) & 2) != 0;
  return {axis, downward ? -1 : 1};
}

std::int64_t get_block(const SamplingPlan& plan) {
  const auto dimensions = static_cast<std::int64_t>(plan.dimensions);
  if (plan.sampling == Sampling::kMorris) return dimensions + 1;
  return plan.sampling == Sampling::kSaltelli ? dimensions + 2 : 1;
}

std::int64_t count_samples(const SamplingPlan& plan) {
  constexpr std::int64_t kMost = std::int64_t{1} << 40;
  if (plan.sampling == Sampling::kGrid) {
    std::int64_t count = 1;
    for (const int levels : plan.levels) count = count > kMost ? count : count * levels;
    return count;
  }
  if (plan.sampling != Sampling::kOneAtATime) return 0;
  std::int64_t count = 1;
  for (const int levels : plan.levels) count += levels;
  return count;
}

std::vector<double> calc_point(const SamplingPlan& plan, std::int64_t sample) {
  switch (plan.sampling) {
    case Sampling::kGrid:
      return calc_grid(plan, sample);
    case Sampling::kOneAtATime:
      return calc_one_at_a_time(plan, sample);
    case Sampling::kMorris:
      return calc_morris(plan, sample);
    case Sampling::kSaltelli:
      return calc_saltelli(plan, sample);
    case Sampling::kSobol: {
      const std::vector<std::uint64_t> words = calc_sobol(plan.dimensions, static_cast<std::uint64_t>(sample));
      std::vector<double> point(plan.dimensions);
      for (std::size_t axis = 0; axis < plan.dimensions; ++axis)
        point[axis] =
            to_unit(words[axis] ^ draw_word(plan.seed, RandomStream::kShift, 0, static_cast<std::uint32_t>(axis)));
      return point;
    }
    case Sampling::kRandom:
    case Sampling::kLatinHypercube:
    case Sampling::kCsv:
    case Sampling::kSubset:
      break;
  }
  std::vector<double> point(plan.dimensions);
  for (std::size_t axis = 0; axis < plan.dimensions; ++axis)
    point[axis] =
        plan.sampling == Sampling::kLatinHypercube ? calc_latin(plan, sample, axis) : draw(plan, sample, axis);
  return point;
}

}  // namespace unlatch::hil
