// The samples of a campaign, or of a part of it, that its results lack: which of them a worker may run now, with which
// inputs, and whether all have come. Those of subset sampling follow from the results of others, so it takes these too.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hil/campaign/campaign.h"
#include "hil/campaign/handout.h"
#include "hil/campaign/result_file.h"
#include "hil/sampling/subset.h"

namespace unlatch::hil {

struct PlannedSample {
  std::int64_t sample = 0;
  std::vector<double> inputs;
};

class SampleSource {
 public:
  // Samples from `first` to before `last`; of subset sampling those of its levels, as far as they are needed. Refers to
  // the campaign. Throws ResultError.
  SampleSource(const Campaign& campaign, std::int64_t first, std::int64_t last, const ResultFile& results);

  // A new worker, by any number, with its threads.
  void join(int worker, int threads) { handout_.join(worker, threads); }
  // Samples that it is to run now, if any; `now`: s, from any origin, never less than before.
  std::vector<PlannedSample> give(int worker, double now);
  // A result has come. Throws ResultError: the worker was not given this sample, or not with these inputs.
  void take(int worker, const SampleRecord& record);
  // All have come.
  [[nodiscard]] bool is_finished() const { return handout_.is_finished() && (!subset_ || subset_->is_finished()); }

 private:
  [[nodiscard]] std::vector<double> draw(std::int64_t sample) const;

  const Campaign& campaign_;
  std::optional<SubsetSimulation> subset_;
  Handout handout_;
};

}  // namespace unlatch::hil
