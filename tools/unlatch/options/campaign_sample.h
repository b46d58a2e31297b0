// A sample of a campaign as a scenario.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <string>

#include "hil/study/campaign/campaign.h"
#include "tools/unlatch/options/scenario_options.h"

namespace unlatch::tools {

// The path is a campaign file's.
bool is_campaign(const ScenarioOptions& options);

// Finds the step of a campaign with a tolerance, as hil::choose_step() does, and writes what it found to standard
// error. False: none meets it, or `stop` was set; that is written too.
bool find_campaign_step(hil::Campaign& campaign, int jobs, const std::atomic<bool>& stop);

// Writes the step that was found for a tolerance, or why there is none, in a line.
void print_step_search(std::FILE* to, const hil::StepSearch& search, bool stopped);

// The path is a campaign's: it is replaced by its scenario with the values of one sample, those of the campaign, or of
// its folder of results, if one is named. Throws hil::ScenarioError.
void choose_sample(ScenarioOptions& options, std::int64_t sample, const std::string& results);

}  // namespace unlatch::tools
