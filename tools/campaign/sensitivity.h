// Sensitivity of a column of a campaign's results to the inputs.
#pragma once

#include <vector>

#include "hil/study/statistics/statistics.h"
#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// Spearman's rank correlation and the first-order index of each input; of designs for it Morris' effects, Sobol'
// indices, or the swing of each parameter alone. `inputs`, `values`: of the rows that have statistics; `column`: of
// `values`.
Json describe_sensitivity(const CampaignData& data, const hil::RankedVariables& inputs,
                          const std::vector<double>& values, std::size_t column);

}  // namespace unlatch::tools
