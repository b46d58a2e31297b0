// Single samples of a campaign as pages with the bodies in motion, beside the campaign's page.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// Flies each sample again and writes its page: PAGE-17.html of sample 17, if the campaign's page is PAGE.html.
// `folder`: of the results. Runs this program's `run` and `report`, one after the other, so that a flight is what they
// make of it. Returns the pages' names without folder, by the samples' numbers; a sample whose values made no valid
// scenario has none. Throws hil::ResultError: the campaign's file has changed, or a flight failed; the loader's
// ScenarioError: that file is gone.
Json fly_samples(const CampaignData& data, const std::string& folder, const std::vector<std::int64_t>& samples,
                 const std::string& page);

}  // namespace unlatch::tools
