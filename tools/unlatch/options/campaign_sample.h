// A sample of a campaign as a scenario.
#pragma once

#include <cstdint>
#include <string>

#include "tools/unlatch/options/scenario_options.h"

namespace unlatch::tools {

// The path is a campaign file's.
bool is_campaign(const ScenarioOptions& options);

// The path is a campaign's: it is replaced by its scenario with the values of one sample, those of the campaign, or of
// its folder of results, if one is named. Throws hil::ScenarioError.
void choose_sample(ScenarioOptions& options, std::int64_t sample, const std::string& results);

}  // namespace unlatch::tools
