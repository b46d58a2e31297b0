// The step of a campaign with a tolerance (hil/study/campaign/samples/campaign_step.h), as its samples show it.
#pragma once

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// The manifest's search, and of the samples: how many were checked, their largest error, which were flown again finer.
// For campaigns with a tolerance.
Json describe_steps(const CampaignData& data);

}  // namespace unlatch::tools
