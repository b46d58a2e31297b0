// The page of `unlatch campaign report`: one HTML file, without a network.
#pragma once

#include <string>

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// Texts of the campaign stay data: no `<` of them is left in the HTML. Of more than 20,000 samples the plot of two
// quantities shows every n-th and the worst; all else is of all samples. `folder`: of the results, for commands.
// `flights`: names of pages beside this one, by the numbers of their samples.
std::string build_campaign_page(const CampaignData& data, const Json& summary, const std::string& folder,
                                const Json& flights);

}  // namespace unlatch::tools
