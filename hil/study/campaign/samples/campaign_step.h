// The step of a campaign with a tolerance: found once before the samples, checked at every hundredth of them.
//
// The step is a function of the campaign's file and the scenario, as the samples are: it does not depend on threads,
// machines, or on which samples run. The campaign then runs as with `--set step.dt=...`, and its fingerprint has it.
#pragma once

#include <atomic>
#include <cstdint>

#include "hil/study/campaign/campaign.h"
#include "hil/study/campaign/samples/sample_record.h"

namespace unlatch::hil {

// Every so many samples one is flown at half the step, too.
inline constexpr std::int64_t kCheckedEvery = 100;

// What is found for this tolerance.
StepSearch search_step(const Campaign& campaign, double tolerance, int jobs, const std::atomic<bool>& stop);
// Finds the step and makes it that of the campaign's scenario (`tree`), with what was found in `step_search`. Nothing
// is done without a tolerance. False: none meets it, or `stop` was set; the tree is then as it was.
bool choose_step(Campaign& campaign, int jobs, const std::atomic<bool>& stop);
// Makes a known step that of the campaign's scenario.
void set_step(Campaign& campaign, double step);

// Checks a sample's record: every hundredth sample, and each that its step does not resolve, is flown at half the step.
// If both differ by more than the tolerance, that one is the sample, and is checked in turn; a sample that no step
// brings within the tolerance is unresolved. For campaigns with a tolerance.
void check_step(const Campaign& campaign, const SampleEvaluator& evaluator, const std::atomic<bool>& stop,
                SampleRecord& record);

// Step that the record was flown at, s.
double get_step(const SampleEvaluator& evaluator, const SampleRecord& record);

}  // namespace unlatch::hil
