#include "tools/unlatch/options/campaign_sample.h"

#include <algorithm>
#include <iterator>

#include "hil/study/campaign/samples/campaign_step.h"
#include "hil/study/campaign/samples/runner.h"
#include "hil/study/evaluation/step_settings.h"
#include "tools/campaign/campaign_data.h"
#include "tools/common/text.h"
#include "tools/program/interrupt.h"

namespace unlatch::tools {
namespace {

// A sample's record from the folder of results, whose campaign is the same.
hil::SampleRecord find_record(const hil::Campaign& campaign, std::int64_t sample, const std::string& results) {
  try {
    const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
    const hil::ResultFile file = hil::ResultFile::open(get_results_path(results), false);
    if (!(file.shape() == get_shape(campaign, evaluator)))
      refuse_option("--results", results + " is of another campaign, scenario or version");
    const auto at = std::find(file.samples().begin(), file.samples().end(), sample);
    if (at == file.samples().end()) refuse_option("--results", results + " has no sample " + std::to_string(sample));
    return file.read(static_cast<std::size_t>(at - file.samples().begin()));
  } catch (const hil::ResultError& error) {
    refuse_option("--results", error.what());
  }
}

// Step of the campaign in the folder.
double read_step(const std::string& results) {
  try {
    return read_manifest(results).at("step").at("step").get<double>();
  } catch (const hil::ResultError& error) {
    refuse_option("--results", error.what());
  } catch (const Json::exception&) {
    refuse_option("--results", results + " is of a campaign without a tolerance");
  }
}

// The sample's inputs, and with a tolerance its step as a setting: from the folder of results, if there is one, else as
// the campaign makes them.
std::vector<hil::Setting> find_settings(hil::Campaign& campaign, std::int64_t sample, const std::string& results) {
  const bool has_tolerance = campaign.tolerance > 0;
  if (results.empty() && campaign.failure && sample >= campaign.failure->samples)
    refuse_option("--sample", "of subset sampling samples from " + std::to_string(campaign.failure->samples) +
                                  " follow from results: add --results DIR, the campaign's folder");
  if (has_tolerance && !results.empty()) set_step(campaign, read_step(results));
  if (has_tolerance && results.empty() && !find_campaign_step(campaign, 1, catch_interrupts()))
    refuse_option("--sample", "the campaign has no step that its samples could be flown at");
  if (results.empty() && !has_tolerance) return make_settings(campaign, draw_inputs(campaign, sample));
  const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
  const hil::SampleRecord record =
      results.empty()
          ? run_together(campaign, evaluator, {{sample, draw_inputs(campaign, sample)}}, catch_interrupts()).at(0)
          : find_record(campaign, sample, results);
  std::vector<hil::Setting> settings = make_settings(campaign, record.inputs);
  if (has_tolerance)
    std::ranges::move(hil::make_step_settings(campaign.tree->get_nominal(), get_step(evaluator, record)),
                      std::back_inserter(settings));
  return settings;
}

}  // namespace

bool find_campaign_step(hil::Campaign& campaign, int jobs, const std::atomic<bool>& stop) {
  if (!(campaign.tolerance > 0)) return true;
  const bool found = choose_step(campaign, jobs, stop);
  print_step_search(stderr, *campaign.step_search, stop);
  return found;
}

void print_step_search(std::FILE* to, const hil::StepSearch& search, bool stopped) {
  std::string text;
  if (search.step)
    text = format("the step is %.9g s, the scenario's %.9g s (%s)", *search.step, search.given,
                  count(search.flights, "flight").c_str());
  else if (stopped)
    text = "interrupted before its step was found";
  else
    text = describe_failure(search) + "; raise the tolerance, or leave it out";
  std::fprintf(to, "tolerance %g: %s\n", search.tolerance, text.c_str());
}

bool is_campaign(const ScenarioOptions& options) {
  return !hil::is_standard_input(options.path) && hil::is_campaign(hil::read_text_file(options.path, "scenario"));
}

void choose_sample(ScenarioOptions& options, std::int64_t sample, const std::string& results) {
  hil::Campaign campaign = hil::load_campaign(options.path, options.overrides);
  if (sample < 0 || sample >= campaign.plan.samples)
    refuse_option("--sample", "the campaign has samples 0 to " + std::to_string(campaign.plan.samples - 1));
  const std::vector<hil::Setting> settings = find_settings(campaign, sample, results);
  options.path = campaign.scenario;
  options.overrides = campaign.tree->get_nominal().overrides;
  for (const hil::Setting& setting : settings) options.overrides.push_back(to_text(setting));
}

}  // namespace unlatch::tools
