// Tables of a campaign for a review, in the units in which its files give limits and inputs: mm, deg/s.
#pragma once

#include <string>

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// A number of the summary in the unit of its requirement or input, and that unit. `item`: with `unit` and `shown`.
double to_shown(const Json& item, double value);
std::string get_shown_unit(const Json& item);

// Requirements, a row each: limits, failures, probability and its bounds, quantiles, tolerance. `summary`: of
// build_summary().
std::string write_requirements_csv(const Json& summary);
// The same as Markdown, and the inputs.
std::string write_review(const Json& summary);

}  // namespace unlatch::tools
