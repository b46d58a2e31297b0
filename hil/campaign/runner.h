// Runs the samples of a campaign on threads of this process. Results are added to the file as they come; which thread
// ran a sample, and when, changes nothing in them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "hil/campaign/sample_source.h"

namespace unlatch::hil {

// Runs samples as the campaign does, side by side; SampleEvaluator::kSideBySide at the most.
std::vector<SampleRecord> run_together(const Campaign& campaign, const SampleEvaluator& evaluator,
                                       std::vector<PlannedSample> samples, const std::atomic<bool>& stop);

// Samples from `first` to before `last`, but those that the file has. `finished` is called after each, by this thread.
// Another thread may set `stop`: samples in flight are left. Throws what append() throws.
void run_samples(const Campaign& campaign, const SampleEvaluator& evaluator, std::int64_t first, std::int64_t last,
                 int jobs, ResultFile& results, const std::atomic<bool>& stop, const std::function<void()>& finished);

}  // namespace unlatch::hil
