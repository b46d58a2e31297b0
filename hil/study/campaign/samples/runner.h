// Runs the samples of a campaign on threads of this process. Results are appended to the file as they arrive; the
// thread and the time of a sample do not influence its result.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "hil/study/campaign/samples/sample_source.h"

namespace unlatch::hil {

// Runs samples side by side, as the campaign does; SampleEvaluator::kSideBySide at the most.
std::vector<SampleRecord> run_together(const Campaign& campaign, const SampleEvaluator& evaluator,
                                       std::vector<PlannedSample> samples, const std::atomic<bool>& stop);

// Runs the samples from `first` to before `last`, except those in the file. `finished` is called after each, by this
// thread. Another thread may set `stop`: samples under way are abandoned. Throws the exceptions of append().
void run_samples(const Campaign& campaign, const SampleEvaluator& evaluator, std::int64_t first, std::int64_t last,
                 int jobs, ResultFile& results, const std::atomic<bool>& stop, const std::function<void()>& finished);

}  // namespace unlatch::hil
