// Statistics of one column of a campaign's table. NaN: no value.
#pragma once

#include <optional>
#include <vector>

#include "hil/study/statistics/statistics.h"
#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

Json to_json(double value);  // null if it is not finite
Json to_json(const hil::Interval& interval);
Json to_json(const std::optional<hil::Interval>& interval);  // null if there is none

// The values without the missing ones, sorted.
std::vector<double> sort_present(std::vector<double> values);
// Keys `quantiles` and `intervals` of these.
void add_quantiles(const std::vector<double>& sorted, Json& to);
// The same without numbers: the values are of chosen points.
void add_no_quantiles(Json& to);
// `column`: its name and unit. `drawn`: the values are draws, which have quantiles.
Json describe_column(const Json& column, const std::vector<double>& values, bool drawn);
// Bands of a curve over the samples at each of its times: null where no sample has a value, and where samples are no
// draws.
Json describe_curve(const CampaignData& data, const Json& curve, bool drawn);

}  // namespace unlatch::tools
