// Parts of a dossier that come from results: the nominal run, the campaign.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hil/scenario/language/record.h"
#include "tools/campaign/campaign_data.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {

// What the factors of credibility get from each part, by their keys.
using Evidence = std::map<std::string, std::vector<std::string>>;

// A word of a shell: between quotation marks if it needs them.
std::string quote_word(const std::string& word);

// status, message, end, hash, model_hash, requirements, accuracy, notices, findings, energy. Without times of the
// machine and paths.
nlohmann::ordered_json build_run_part(const RunReport& report, const hil::ScenarioRecord& record,
                                      const std::string& skipped_accuracy, Evidence& evidence);

// samples, hash, statuses, requirements with probabilities, sensitivities and their worst samples, inputs. `command`:
// runs a sample, without its number.
nlohmann::ordered_json build_campaign_part(const CampaignData& data, const std::string& command, Evidence& evidence);

}  // namespace unlatch::tools
