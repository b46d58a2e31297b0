// Failures of a campaign's samples: their probability, and the worst samples.
#pragma once

#include <optional>

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// Failures of a requirement, bounds of their probability and its convergence; quantiles and tolerance limits of its
// value. `population`: the rows that are draws, of which probabilities, quantiles and limits are; nothing: there are
// none of them, null.
Json describe_requirement(const CampaignData& data, const std::optional<CampaignData>& population,
                          const Json& requirement);
// Failures of any requirement, and bounds of their probability.
Json describe_any_failure(const CampaignData& data, const std::optional<CampaignData>& population);
// How many of the samples have values of requirements on reactions that leave out the impulse of a blow: by the
// requirements' names; those without such a sample are left out.
Json count_blows(const CampaignData& data);
// Likewise those whose values may be off between steps by more than a thousandth: {samples, by}, by how much at most.
Json count_uncertain(const CampaignData& data);
// Numbers of the unresolved samples.
Json list_unresolved(const CampaignData& data);
// Numbers of the worst samples: faults first, then by the smallest margin of all that a sample may fail, in units of
// the spread of that margin over all samples.
Json list_worst(const CampaignData& data);
// Levels of subset sampling, its estimate, and the probability of each margin: [margin, probability] from 1 down.
Json describe_rare(const CampaignData& data, const hil::RareFailure& failure);

// "gap below 0.01 m". `rare`: of describe_rare().
std::string describe_rare_failure(const Json& rare);
// The probability that a subset simulation found, or why there is none, and how sure it is.
struct RareResult {
  std::string text, remark;
};
RareResult describe_rare_result(const Json& rare);

}  // namespace unlatch::tools
