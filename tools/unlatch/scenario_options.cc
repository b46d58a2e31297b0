#include <algorithm>
#include <cmath>
#include <cstdio>

#include "hil/campaign/campaign.h"
#include "hil/run/run.h"
#include "hil/synthesis/problem.h"
#include "tools/campaign/campaign_data.h"
#include "tools/unlatch/commands.h"

namespace unlatch::tools {
namespace {

constexpr double kSameTime = 1e-6;  // of a step

// All digits: what is read back is what was typed.
std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// The earliest time at which a condition can hold, s.
double calc_earliest(const Condition& when) {
  using Kind = Condition::Kind;
  if (when.kind == Kind::kTime) return when.below ? 0 : when.threshold;
  if ((when.kind != Kind::kAll && when.kind != Kind::kAny) || when.parts.empty()) return 0;
  std::vector<double> times;
  for (const Condition& part : when.parts) times.push_back(calc_earliest(part));
  return when.kind == Kind::kAll ? *std::max_element(times.begin(), times.end())
                                 : *std::min_element(times.begin(), times.end());
}

}  // namespace

std::vector<std::string> list_notes(const hil::Scenario& scenario) {
  std::vector<std::string> notes;
  for (const Event& event : scenario.model.events) {
    const double earliest = calc_earliest(event.when) + event.delay;
    if (earliest <= scenario.until) continue;
    char text[160];
    std::snprintf(text, sizeof text, "cannot happen before %.6g s, and the run ends at %.6g s", earliest,
                  scenario.until);
    notes.push_back("event '" + event.name + "'" + (event.subject.empty() ? "" : " of '" + event.subject + "'") + " " +
                    text);
  }
  return notes;
}

bool is_campaign(const ScenarioOptions& options) {
  return !hil::is_standard_input(options.path) && hil::is_campaign(hil::read_text_file(options.path, "scenario"));
}

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
    const hil::SampleEvaluator evaluator(*campaign.tree);
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

void choose_sample(ScenarioOptions& options, std::int64_t sample, const std::string& results) {
  const hil::Campaign campaign = hil::load_campaign(options.path, options.overrides);
  if (sample < 0 || sample >= campaign.plan.samples)
    refuse_option("--sample", "the campaign has samples 0 to " + std::to_string(campaign.plan.samples - 1));
  options.path = campaign.scenario;
  options.overrides = campaign.tree->get_nominal().overrides;
  for (const hil::Setting& setting : make_settings(campaign, find_inputs(campaign, sample, results)))
    options.overrides.push_back(to_text(setting));
}

void add_scenario_options(Command command, ScenarioOptions& options) {
  command.add_option("SCENARIO", options.path, "scenario file (.yaml); - for standard input").required();
  command.add_option("--until", options.until, "end of the run, s or with its unit (default: the scenario's)")
      .type_name("SECONDS")
      .seconds();
  command.add_option("--dt", options.dt, "step, s (default: the scenario's)").type_name("SECONDS").seconds();
  command
      .add_option("--set", options.overrides,
                  "replaces one value of the scenario, for example bodies.core.mass=98000; repeatable")
      .type_name("PATH=VALUE")
      .repeatable();
}

namespace {

void refuse_design_problem(const std::string& path) {
  if (hil::is_standard_input(path) || !hil::is_design_problem(hil::read_text_file(path, "scenario"))) return;
  throw hil::ScenarioError({{.file = path,
                             .mark = {},
                             .override_text = "",
                             .what = "this is a problem of synthesis, not a scenario",
                             .mend = "`unlatch optimize` looks for its values, and its DIR/patch.yaml runs"}});
}

}  // namespace

hil::Scenario load(const ScenarioOptions& options) {
  refuse_design_problem(options.path);
  std::vector<std::string> overrides = options.overrides;
  if (options.dt > 0) overrides.push_back("step.dt=" + to_text(options.dt));
  if (options.until > 0) overrides.push_back("step.until=" + to_text(options.until));
  hil::Scenario scenario = hil::load_scenario(options.path, overrides);
  const double end = static_cast<double>(calc_last_tick(scenario)) * scenario.dt;
  if (std::abs(end - scenario.until) > kSameTime * scenario.dt) {
    std::fprintf(stderr, "note: %.9g s is not on a tick; the run ends at %.9g s\n", scenario.until, end);
  }
  if (options.until > 0) return scenario;  // an end before some events is wanted
  for (const std::string& note : list_notes(scenario)) std::fprintf(stderr, "note: %s\n", note.c_str());
  return scenario;
}

void warn_of_unstable_elements(const hil::Scenario& scenario) {
  const auto simulation = hil::build_simulation(scenario);
  for (const hil::SpringResolution& element : hil::calc_resolutions(*simulation)) {
    if (element.implicit || scenario.dt * element.get_worst() <= kStable) continue;
    std::fprintf(stderr,
                 "warning: element '%s' is too stiff for this step and will be unstable: h*omega %.3g, h*decay %.3g; "
                 "see `unlatch check`\n",
                 scenario.model.element_name(element.element).c_str(), scenario.dt * element.largest_omega,
                 scenario.dt * element.largest_decay);
  }
}

void add_junit_option(Command command, std::string& junit) {
  command.add_option("--junit", junit, "the requirements as test cases, JUnit XML").type_name("FILE");
}

void add_output_options(Command command, OutputOptions& options) {
  command.add_json_option(options.json);
  add_junit_option(command, options.junit);
  command.add_option("--log", options.log, "recording to write (LCM event log), for `unlatch replay`")
      .type_name("FILE");
  command.parsed_callback([&options] {
    if (options.log == "-") refuse_option("--log", "a recording goes to a file, not to standard output");
    if (!options.log.empty() && options.log == options.json)
      refuse_option("--log", "the recording and the JSON need different files");
  });
}

void add_outputs_option(Command command, std::string& text) {
  command
      .add_option("--outputs", text,
                  "outputs to write, by patterns of their names (`unlatch check SCENARIO --outputs` lists them), each "
                  "with the ticks from one row to the next or a rate: 'core.*,*.force@10,sensor.*@100Hz' (default: "
                  "those of the scenario)")
      .type_name("PATTERN,...");
}

std::vector<hil::OutputGroup> choose_outputs(const hil::Scenario& scenario, const std::string& text) {
  if (text.empty()) return scenario.outputs;
  try {
    return hil::parse_outputs(text, scenario.dt, hil::list_outputs(scenario));
  } catch (const std::invalid_argument& error) {
    refuse_option("--outputs", error.what());
  }
}

std::int64_t calc_last_tick(const hil::Scenario& scenario) {
  return hil::calc_nearest_tick(scenario.until, scenario.dt);
}

}  // namespace unlatch::tools
