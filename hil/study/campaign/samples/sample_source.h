// Samples of a campaign, or of a part of it, that are not in its results: those that a worker may run now, with their
// inputs, and the end of the campaign. Samples of subset sampling depend on results of others, so the source takes
// results too.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hil/study/campaign/campaign.h"
#include "hil/study/campaign/samples/handout.h"
#include "hil/study/campaign/samples/result_file.h"
#include "hil/study/sampling/subset.h"

namespace unlatch::hil {

struct PlannedSample {
  std::int64_t sample = 0;
  std::vector<double> inputs;
};

class SampleSource {
 public:
  // Provides the samples from `first` to before `last`; of subset sampling those of its levels, as far as they are
  // needed. Keeps a reference to the campaign. Throws ResultError.
  SampleSource(const Campaign& campaign, std::int64_t first, std::int64_t last, const ResultFile& results);

  // Adds a worker, identified by any number, with its threads.
  void join(int worker, int threads) { handout_.join(worker, threads); }
  // Samples to run now, if any; `now`: s, from any origin, never less than before.
  std::vector<PlannedSample> assign(int worker, double now);
  // Takes a result. Throws ResultError if the worker was not given this sample, or other inputs.
  void take(int worker, const SampleRecord& record);
  // True once all results are there.
  [[nodiscard]] bool is_finished() const { return handout_.is_finished() && (!subset_ || subset_->is_finished()); }

 private:
  [[nodiscard]] std::vector<double> draw(std::int64_t sample) const;

  const Campaign& campaign_;
  std::optional<SubsetSimulation> subset_;
  Handout handout_;
};

}  // namespace unlatch::hil
