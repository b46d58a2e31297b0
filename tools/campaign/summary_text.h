// The statistics of a campaign as text.
#pragma once

#include <cstdio>

#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {

// `summary`: of build_summary().
void print_summary(std::FILE* to, const Json& summary);

}  // namespace unlatch::tools
