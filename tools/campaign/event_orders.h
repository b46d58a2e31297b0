// Orders in which the events of a campaign's samples came.
#pragma once

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// Number of different orders; of the most frequent ones their samples.
Json list_orders(const CampaignData& data);

}  // namespace unlatch::tools
