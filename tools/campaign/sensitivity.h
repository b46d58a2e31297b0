// Sensitivity of a column of a campaign's results to the inputs.
#pragma once

#include <vector>

#include "hil/study/statistics/statistics.h"
#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// Spearman's rank correlation and the first-order index of each input; of designs for it Morris' effects or Sobol'
// indices. `values`: of the
// column.
Json describe_sensitivity(const CampaignData& data, const hil::RankedVariables& inputs,
                          const std::vector<double>& values);

}  // namespace unlatch::tools
