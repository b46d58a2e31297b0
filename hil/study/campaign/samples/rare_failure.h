// Failure whose probability subset sampling estimates. Key `subset` of a campaign file.
#pragma once

#include <cstdint>
#include <string>

#include "hil/study/campaign/samples/sample_record.h"
#include "hil/study/sampling/subset.h"

namespace unlatch::hil {

// Plan of the subset simulation for the number of dimensions and the seed of the campaign.
SubsetPlan make_subset_plan(const RareFailure& failure, const SamplingPlan& plan);

// Distance of a sample's value from the limit, in the column's unit; below 0 the sample fails. -infinity: it has no
// such value or did not run to its end, which is a failure too. `value`: of the failure's column.
double calc_failure_margin(const RareFailure& failure, SampleStatus status, double value);
double calc_failure_margin(const RareFailure& failure, const SampleRecord& record);

}  // namespace unlatch::hil
