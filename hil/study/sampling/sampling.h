// Points of the unit cube. Point i depends on the plan and i alone; none is kept.
//
//   random            independent numbers
//   latin-hypercube   each of the N equal parts of each axis once: the part of sample i on axis j is a permutation of
//                     0 … N − 1 that is computed, not stored: a Feistel network over Philox, walked until it is below N
//   sobol             Sobol' sequence (direction numbers of Joe and Kuo 2008, from Boost), shifted by the seed's bits
//   grid              all combinations of `levels` equally probable values, the last axis fastest
//   one-at-a-time     sample 0: all medians; then each axis at its `levels` values, the others at their medians
//   morris            trajectories of d + 1 points, each one step of one axis from the last (Morris 1991, p levels)
//   saltelli          blocks of d + 2 points: A, B, and A with one axis of B (Saltelli 2010)
//   csv               no points: the values are the table's rows
//   subset            of the first level independent numbers; the other levels are in subset.h
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace unlatch::hil {

enum class Sampling { kRandom, kLatinHypercube, kSobol, kGrid, kOneAtATime, kMorris, kSaltelli, kCsv, kSubset };
extern const std::vector<std::string> kSamplingNames;  // "random" …, in the order of the enum

struct SamplingPlan {
  Sampling sampling = Sampling::kRandom;
  std::uint64_t seed = 0;
  std::int64_t samples = 0;
  std::size_t dimensions = 0;
  std::vector<int> levels;  // levels of a grid and of one-at-a-time, for each axis
};

// Coordinates of a point, each in (0, 1). `sample`: from 0.
std::vector<double> calc_point(const SamplingPlan& plan, std::int64_t sample);

// What the samples of a design say of the distributions: of probabilities, quantiles and tolerance limits.
enum class SampleBasis {
  kIndependent,  // independent draws: what Clopper and Pearson, Wilks and order statistics assume
  kStratified,   // one draw in each part of each axis: means vary hardly more than those of independent draws
  kQuasiRandom,  // each point is a draw, but all together are not independent: mostly less scattered, without a bound
  kBaseRows,     // the first two samples of each block are independent draws, the others repeat their coordinates
  kTable,        // what the table's rows are
  kChosen,       // chosen points: nothing
};
SampleBasis get_basis(Sampling sampling);
// The same as a sentence; empty for independent draws.
std::string describe_basis(Sampling sampling);
inline constexpr std::int64_t kBaseRowsEach = 2;  // of a block of saltelli: A and B

// Number of samples that the plan prescribes; 0 if the user may choose it.
std::int64_t count_samples(const SamplingPlan& plan);

// Samples of one block of a design: trajectories, A-B blocks; 1 for all others.
std::int64_t get_block(const SamplingPlan& plan);

// The axis that sample `k` of trajectory `trajectory` moved, k from 1, and its sign.
struct MorrisStep {
  std::size_t axis = 0;
  int sign = 1;
};
MorrisStep get_morris_step(const SamplingPlan& plan, std::int64_t trajectory, std::size_t k);
inline constexpr double kMorrisStep = 2.0 / 3;  // of four levels, 0 1/3 2/3 1

}  // namespace unlatch::hil
