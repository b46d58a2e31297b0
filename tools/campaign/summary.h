// The statistics of a campaign as JSON, for programs and the page.
#pragma once

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// schema, samples, hash, statuses, requirements, worst; columns with their quantiles; sensitivities; orders of events;
// bands of curves; of subset sampling `rare`: levels, estimate.
Json build_summary(const CampaignData& data);

}  // namespace unlatch::tools
