// Findings about the scenario of a campaign before it runs: as it stands, and at the ends of what may be drawn.
#pragma once

#include <vector>

#include "hil/run/findings/finding.h"
#include "hil/study/campaign/campaign.h"

namespace unlatch::hil {

struct CampaignFinding {
  Finding finding;  // of the first that has it
  int corners = 0;  // of kFindingCorners, that have it; 0: the scenario as it stands has it
};
// Corners that are looked at, each with every parameter at one of its ends.
inline constexpr int kFindingCorners = 8;

// Findings of a scenario as it stands, then those that others with the values of corners add.
std::vector<CampaignFinding> list_findings_of_corners(const ScenarioTree& tree,
                                                      const std::vector<std::vector<Setting>>& corners);

// Findings of the scenario as it stands, then those that corners add. Takes as long as `check` of so many scenarios.
std::vector<CampaignFinding> list_campaign_findings(const Campaign& campaign);

}  // namespace unlatch::hil
