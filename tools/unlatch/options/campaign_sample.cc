#include "tools/unlatch/options/campaign_sample.h"

#include <algorithm>

#include "hil/study/campaign/campaign.h"
#include "tools/campaign/campaign_data.h"

namespace unlatch::tools {
namespace {

// The inputs of a sample: from the campaign alone, or from the folder of its results.
std::vector<double> find_inputs(const hil::Campaign& campaign, std::int64_t sample, const std::string& results) {
  if (results.empty()) {
    if (campaign.failure && sample >= campaign.failure->samples)
      refuse_option("--sample", "of subset sampling samples from " + std::to_string(campaign.failure->samples) +
                                    " follow from results: add --results DIR, the campaign's folder");
    return draw_inputs(campaign, sample);
  }
  try {
    const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
    const hil::ResultFile file = hil::ResultFile::open(get_results_path(results), false);
    if (!(file.shape() == get_shape(campaign, evaluator)))
      refuse_option("--results", results + " is of another campaign, scenario or version");
    const auto at = std::find(file.samples().begin(), file.samples().end(), sample);
    if (at == file.samples().end()) refuse_option("--results", results + " has no sample " + std::to_string(sample));
    return file.read(static_cast<std::size_t>(at - file.samples().begin())).inputs;
  } catch (const hil::ResultError& error) {
    refuse_option("--results", error.what());
  }
}

}  // namespace

bool is_campaign(const ScenarioOptions& options) {
  return !hil::is_standard_input(options.path) && hil::is_campaign(hil::read_text_file(options.path, "scenario"));
}

void choose_sample(ScenarioOptions& options, std::int64_t sample, const std::string& results) {
  const hil::Campaign campaign = hil::load_campaign(options.path, options.overrides);
  if (sample < 0 || sample >= campaign.plan.samples)
    refuse_option("--sample", "the campaign has samples 0 to " + std::to_string(campaign.plan.samples - 1));
  options.path = campaign.scenario;
  options.overrides = campaign.tree->get_nominal().overrides;
  for (const hil::Setting& setting : make_settings(campaign, find_inputs(campaign, sample, results)))
    options.overrides.push_back(to_text(setting));
}

}  // namespace unlatch::tools
